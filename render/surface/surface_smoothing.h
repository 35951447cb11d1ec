// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// Vertex adjacency of a closed triangle mesh.
class Neighbours {
 public:
  Neighbours(std::size_t vertices, std::span<const std::uint32_t> indices);

  /// The part of `all`, a vector with one value per neighbour of each vertex, that belongs to a vertex.
  template <class Vector>
  [[nodiscard]] auto part_of(Vector& all, std::size_t vertex) const {
    return std::span(all.data() + starts_[vertex], starts_[vertex + 1] - starts_[vertex]);
  }
  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t vertex) const { return part_of(next_, vertex); }
  /// For each neighbour the third corner of the triangle in which it follows the vertex.
  [[nodiscard]] std::span<const std::uint32_t> opposite(std::size_t vertex) const { return part_of(opposite_, vertex); }
  /// The size of a vector with one value per neighbour of each vertex.
  [[nodiscard]] std::size_t count() const { return next_.size(); }

 private:
  std::vector<std::uint32_t> starts_;
  std::vector<std::uint32_t> next_;
  std::vector<std::uint32_t> opposite_;
};

/// Smooths voxel steps in the shading: replaces each normal, `rounds` times, by the mean of itself and its neighbours
/// on the same face. Normals on an edge between faces stay as they are.
void smooth_normals(const Neighbours& neighbours, std::vector<Eigen::Vector3f>& normals, int rounds);

/// Fits points to their smoothed normals: moves each, `rounds` times, to the mean of the positions that its neighbours
/// predict from the normals between them (after Sun, Rosin, Martin and Langbein 2007, doi:10.1109/TVCG.2007.1065, §5,
/// with vertex normals), by at most `max_displacement`. Removes voxel terraces from outlines.
void fit_to_normals(const Neighbours& neighbours, const std::vector<Eigen::Vector3f>& normals,
                    std::vector<Eigen::Vector3f>& points, int rounds, float max_displacement);

/// Mean value coordinates of each vertex in its neighbours (Floater 2003, doi:10.1016/S0167-8396(03)00002-5), 1 on
/// average. A mean with them preserves linear functions on uneven triangles.
std::vector<float> mean_value_weights(const Neighbours& neighbours, const std::vector<Eigen::Vector3f>& points);

/// Replaces each value, `rounds` times, by the mean over itself and its neighbours, weighted by `weights` per vertex
/// times `edge_weights` from mean_value_weights(). Values whose weights are all 0 stay.
void smooth_values(const Neighbours& neighbours, const std::vector<float>& edge_weights,
                   const std::vector<float>& weights, std::vector<float>& values, int rounds);

/// The tool as a triangle mesh for OpenGL.
struct ToolSurface {
  /// Floats per vertex: position in T (mm), outward normal.
  static constexpr std::array kAttributeSizes{3, 3};
  static constexpr std::size_t kStride = 6;

  std::vector<float> vertices;
  std::vector<std::uint32_t> indices;
};

/// Each corner gets the mean normal of adjacent triangles within the crease angle, so that cutting edges stay sharp.
ToolSurface make_tool_surface(const TriangleMesh& mesh);

}  // namespace reamsim
