// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/surface/bone_surface.h"

#include <algorithm>

#include "sim/base/parallel.h"

namespace reamsim {
namespace {

/// Crease weights are 1 below the angle of the first cosine (14°) and 0 above that of the second (32°).
constexpr float kSameCosine = 0.970F;
constexpr float kCreaseCosine = 0.850F;
constexpr std::size_t kSmoothingGrain = 4096;
/// Lower bound of an edge's length, against division by zero.
constexpr float kMinEdge_voxels = 1e-3F;

/// Weight of a neighbour by its normal: 0 across a crease, 1 on the same face.
float crease_weight(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return std::clamp((a.dot(b) - kCreaseCosine) / (kSameCosine - kCreaseCosine), 0.0F, 1.0F);
}

/// Replaces each value, `rounds` times, by step(its index), which reads the values of the round before.
template <class Value, class Step>
void repeat(std::vector<Value>& values, int rounds, const Step& step) {
  std::vector<Value> next(values.size());
  for (int round = 0; round < rounds; ++round) {
    parallel_items(values.size(), kSmoothingGrain, [&](std::size_t i) { next[i] = step(i); });
    values.swap(next);
  }
}

}  // namespace

Neighbours::Neighbours(std::size_t vertices, std::span<const std::uint32_t> indices) : starts_(vertices + 1, 0) {
  // On a closed surface each neighbour is the next corner in exactly one triangle at the vertex.
  for (const std::uint32_t vertex : indices) ++starts_[vertex + 1];
  for (std::size_t i = 0; i < vertices; ++i) starts_[i + 1] += starts_[i];
  next_.resize(indices.size());
  opposite_.resize(indices.size());
  std::vector<std::uint32_t> end(starts_.begin(), starts_.end() - 1);
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const std::size_t first = i - i % 3;
    const std::uint32_t slot = end[indices[i]]++;
    next_[slot] = indices[first + (i + 1 - first) % 3];
    opposite_[slot] = indices[first + (i + 2 - first) % 3];
  }
}

void smooth_normals(const Neighbours& neighbours, std::vector<Eigen::Vector3f>& normals, int rounds) {
  const std::vector<Eigen::Vector3f> original = normals;
  repeat(normals, rounds, [&](std::size_t i) -> Eigen::Vector3f {
    Eigen::Vector3f sum = normals[i];
    for (const std::uint32_t other : neighbours.of(i)) {
      sum += crease_weight(normals[i], normals[other]) * normals[other];
    }
    return sum.normalized();
  });
  // Across an edge smoothing would make each normal that of one face or of the other, and triangles do not end at the
  // edge: it would be a row of bright and dark teeth.
  repeat(normals, 1, [&](std::size_t i) -> Eigen::Vector3f {
    float same_face = 1;
    for (const std::uint32_t other : neighbours.of(i)) {
      same_face = std::min(same_face, crease_weight(original[i], original[other]));
    }
    return (same_face * normals[i] + (1 - same_face) * original[i]).normalized();
  });
}

void fit_to_normals(const Neighbours& neighbours, const std::vector<Eigen::Vector3f>& normals,
                    std::vector<Eigen::Vector3f>& points, int rounds, float max_displacement) {
  const std::vector<Eigen::Vector3f> original = points;
  repeat(points, rounds, [&](std::size_t i) -> Eigen::Vector3f {
    Eigen::Vector3f move = Eigen::Vector3f::Zero();
    float weights = 1;
    for (const std::uint32_t other : neighbours.of(i)) {
      const float weight = crease_weight(normals[i], normals[other]);
      // A chord of a round surface is perpendicular to the mean of the normals at its ends.
      const Eigen::Vector3f between = (normals[i] + normals[other]).normalized();
      move += weight * between.dot(points[other] - points[i]) * between;
      weights += weight;
    }
    const Eigen::Vector3f away = points[i] + move / weights - original[i];
    return original[i] + away * std::min(1.0F, max_displacement / std::max(away.norm(), 1e-9F));
  });
}

std::vector<float> mean_value_weights(const Neighbours& neighbours, const std::vector<Eigen::Vector3f>& points) {
  std::vector<float> out(neighbours.count(), 0);
  parallel_items(points.size(), kSmoothingGrain, [&](std::size_t i) {
    const auto ring = neighbours.of(i), opposite = neighbours.opposite(i);
    const auto own = neighbours.part_of(out, i);
    float total = 0;
    for (std::size_t n = 0; n < ring.size(); ++n) {
      const Eigen::Vector3f a = points[ring[n]] - points[i];
      const Eigen::Vector3f b = points[opposite[n]] - points[i];
      const float a_length = std::max(a.norm(), kMinEdge_voxels), b_length = std::max(b.norm(), kMinEdge_voxels);
      // tan(angle between a and b / 2).
      const float tangent = a.cross(b).norm() / std::max(a_length * b_length + a.dot(b), 1e-3F * a_length * b_length);
      own[n] += tangent / a_length;
      const auto other = std::ranges::find(ring, opposite[n]);
      if (other != ring.end()) own[static_cast<std::size_t>(other - ring.begin())] += tangent / b_length;
      total += tangent / a_length + tangent / b_length;
    }
    const float scale = total > 0 ? static_cast<float>(ring.size()) / total : 0;
    for (float& weight : own) weight *= scale;
  });
  return out;
}

void smooth_values(const Neighbours& neighbours, const std::vector<float>& edge_weights,
                   const std::vector<float>& weights, std::vector<float>& values, int rounds) {
  repeat(values, rounds, [&](std::size_t i) {
    float sum = weights[i] * values[i];
    float total = weights[i];
    const auto ring = neighbours.of(i);
    const auto own = neighbours.part_of(edge_weights, i);
    for (std::size_t n = 0; n < ring.size(); ++n) {
      const float weight = own[n] * weights[ring[n]];
      sum += weight * values[ring[n]];
      total += weight;
    }
    return total > 0 ? sum / total : values[i];
  });
}

ToolSurface make_tool_surface(const TriangleMesh& mesh) {
  constexpr double kToolCreaseCosine = 0.80;  // 37°
  const std::size_t count = mesh.triangles.size();
  std::vector<Vec3> areas(count);  // normal times twice the area
  std::vector<std::vector<std::uint32_t>> around(mesh.vertices.size());
  for (std::size_t t = 0; t < count; ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    areas[t] = (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]);
    for (const std::int32_t corner : mesh.triangles[t]) around[corner].push_back(static_cast<std::uint32_t>(t));
  }
  ToolSurface out;
  out.vertices.reserve(count * 3 * ToolSurface::kStride);
  for (std::size_t t = 0; t < count; ++t) {
    const Vec3 own = areas[t].normalized();
    for (const std::int32_t corner : mesh.triangles[t]) {
      Vec3 sum = Vec3::Zero();
      for (const std::uint32_t other : around[corner]) {
        if (areas[other].dot(own) >= kToolCreaseCosine * areas[other].norm()) sum += areas[other];
      }
      const Eigen::Vector3f normal = (sum.norm() > 0 ? sum.normalized() : own).cast<float>();
      const Eigen::Vector3f position = mesh.vertices[corner].cast<float>();
      out.indices.push_back(static_cast<std::uint32_t>(out.vertices.size() / ToolSurface::kStride));
      out.vertices.insert(out.vertices.end(), position.data(), position.data() + 3);
      out.vertices.insert(out.vertices.end(), normal.data(), normal.data() + 3);
    }
  }
  return out;
}

}  // namespace reamsim
