#include "render/surface/surface_smoothing.h"

#include <algorithm>

#include "sim/base/parallel.h"

namespace reamsim {
namespace {

/// Neighbours count fully below the first of these cosines' angles and not at all above the second (14° and 32°).
constexpr float kSameCosine = 0.970F;
constexpr float kCreaseCosine = 0.850F;
constexpr std::size_t kSmoothingGrain = 4096;
/// Shorter edges count as so long.
constexpr float kLeastEdge_voxels = 1e-3F;

/// How much a neighbour counts: 0 across a crease, 1 on the same face.
float crease_weight(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return std::clamp((a.dot(b) - kCreaseCosine) / (kSameCosine - kCreaseCosine), 0.0F, 1.0F);
}

}  // namespace

Neighbours::Neighbours(std::size_t vertices, std::span<const std::uint32_t> indices) : starts_(vertices + 1, 0) {
  // Round a closed surface every neighbour is the next corner of exactly one of the triangles at a vertex.
  for (const std::uint32_t vertex : indices) ++starts_[vertex + 1];
  for (std::size_t i = 0; i < vertices; ++i) starts_[i + 1] += starts_[i];
  joined_.resize(indices.size());
  third_.resize(indices.size());
  std::vector<std::uint32_t> next(starts_.begin(), starts_.end() - 1);
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const std::size_t first = i - i % 3;
    const std::uint32_t place = next[indices[i]]++;
    joined_[place] = indices[first + (i + 1 - first) % 3];
    third_[place] = indices[first + (i + 2 - first) % 3];
  }
}

void smooth_normals(const Neighbours& neighbours, std::vector<Eigen::Vector3f>& normals, int rounds) {
  std::vector<Eigen::Vector3f> next(normals.size());
  for (int round = 0; round < rounds; ++round) {
    parallel_ranges(normals.size(), kSmoothingGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const Eigen::Vector3f own = normals[i];
        Eigen::Vector3f sum = own;
        for (const std::uint32_t other : neighbours.of(i)) {
          sum += crease_weight(own, normals[other]) * normals[other];
        }
        next[i] = sum.normalized();
      }
    });
    normals.swap(next);
  }
}

void fit_to_normals(const Neighbours& neighbours, const std::vector<Eigen::Vector3f>& normals,
                    std::vector<Eigen::Vector3f>& points, int rounds, float most) {
  const std::vector<Eigen::Vector3f> home = points;
  std::vector<Eigen::Vector3f> next(points.size());
  for (int round = 0; round < rounds; ++round) {
    parallel_ranges(points.size(), kSmoothingGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        Eigen::Vector3f move = Eigen::Vector3f::Zero();
        float weights = 1;
        for (const std::uint32_t other : neighbours.of(i)) {
          const float weight = crease_weight(normals[i], normals[other]);
          // A chord of a round surface is perpendicular to the mean of the normals at its ends.
          const Eigen::Vector3f between = (normals[i] + normals[other]).normalized();
          move += weight * between.dot(points[other] - points[i]) * between;
          weights += weight;
        }
        const Eigen::Vector3f away = points[i] + move / weights - home[i];
        next[i] = home[i] + away * std::min(1.0F, most / std::max(away.norm(), 1e-9F));
      }
    });
    points.swap(next);
  }
}

std::vector<float> mean_value_weights(const Neighbours& neighbours, const std::vector<Eigen::Vector3f>& points) {
  std::vector<float> out(neighbours.count(), 0);
  parallel_ranges(points.size(), kSmoothingGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto joined = neighbours.of(i), third = neighbours.after(i);
      const auto own = neighbours.part_of(out, i);
      float total = 0;
      for (std::size_t n = 0; n < joined.size(); ++n) {
        const Eigen::Vector3f a = points[joined[n]] - points[i];
        const Eigen::Vector3f b = points[third[n]] - points[i];
        const float a_length = std::max(a.norm(), kLeastEdge_voxels), b_length = std::max(b.norm(), kLeastEdge_voxels);
        // The tangent of half the angle between them.
        const float tangent = a.cross(b).norm() / std::max(a_length * b_length + a.dot(b), 1e-3F * a_length * b_length);
        own[n] += tangent / a_length;
        const auto other = std::ranges::find(joined, third[n]);
        if (other != joined.end()) own[static_cast<std::size_t>(other - joined.begin())] += tangent / b_length;
        total += tangent / a_length + tangent / b_length;
      }
      const float scale = total > 0 ? static_cast<float>(joined.size()) / total : 0;
      for (float& weight : own) weight *= scale;
    }
  });
  return out;
}

void smooth_values(const Neighbours& neighbours, const std::vector<float>& even, const std::vector<float>& weights,
                   std::vector<float>& values, int rounds) {
  std::vector<float> next(values.size());
  for (int round = 0; round < rounds; ++round) {
    parallel_ranges(values.size(), kSmoothingGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        float sum = weights[i] * values[i];
        float total = weights[i];
        const auto joined = neighbours.of(i);
        const auto own = neighbours.part_of(even, i);
        for (std::size_t n = 0; n < joined.size(); ++n) {
          const float weight = own[n] * weights[joined[n]];
          sum += weight * values[joined[n]];
          total += weight;
        }
        next[i] = total > 0 ? sum / total : values[i];
      }
    });
    values.swap(next);
  }
}

}  // namespace reamsim
