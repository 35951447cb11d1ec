#include "render/surface_smoothing.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace reamsim {
namespace {

/// Neighbours count fully below the first of these cosines' angles and not at all above the second (8° and 26°).
constexpr float kSameCosine = 0.990F;
constexpr float kCreaseCosine = 0.900F;
constexpr std::size_t kGrain = 4096;

}  // namespace

Neighbours::Neighbours(std::size_t vertices, std::span<const std::uint32_t> indices) : starts_(vertices + 1, 0) {
  // Round a closed surface every neighbour is the next corner of exactly one of the triangles at a vertex.
  for (const std::uint32_t vertex : indices) ++starts_[vertex + 1];
  for (std::size_t i = 0; i < vertices; ++i) starts_[i + 1] += starts_[i];
  joined_.resize(indices.size());
  std::vector<std::uint32_t> next(starts_.begin(), starts_.end() - 1);
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const std::size_t following = i % 3 == 2 ? i - 2 : i + 1;
    joined_[next[indices[i]]++] = indices[following];
  }
}

void smooth_normals(const Neighbours& neighbours, std::vector<Eigen::Vector3f>& normals, int rounds) {
  std::vector<Eigen::Vector3f> next(normals.size());
  for (int round = 0; round < rounds; ++round) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, normals.size(), kGrain), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) {
        const Eigen::Vector3f own = normals[i];
        Eigen::Vector3f sum = own;
        for (const std::uint32_t other : neighbours.of(i)) {
          const float cosine = own.dot(normals[other]);
          sum += std::clamp((cosine - kCreaseCosine) / (kSameCosine - kCreaseCosine), 0.0F, 1.0F) * normals[other];
        }
        next[i] = sum.normalized();
      }
    });
    normals.swap(next);
  }
}

void smooth_values(const Neighbours& neighbours, std::vector<float>& values, int rounds) {
  std::vector<float> next(values.size());
  for (int round = 0; round < rounds; ++round) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, values.size(), kGrain), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) {
        float sum = values[i];
        for (const std::uint32_t other : neighbours.of(i)) sum += values[other];
        next[i] = sum / static_cast<float>(1 + neighbours.of(i).size());
      }
    });
    values.swap(next);
  }
}

}  // namespace reamsim
