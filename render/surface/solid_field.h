// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

/// The bone fraction of each voxel, 0…1, with each brick (8×8×8 voxels) classified as air, bone or mixed.
class Occupancy {
 public:
  enum class Kind : std::uint8_t { kEmpty, kFull, kMixed };

  /// Both must outlive this.
  Occupancy(const Voxmap& voxmap, const FillBricks& fill);

  /// Reclassifies bricks whose fill has changed.
  void update(const std::vector<Vec3i>& bricks);

  [[nodiscard]] const Voxmap& voxmap() const { return voxmap_; }
  [[nodiscard]] Vec3i brick_dims() const { return bricks_.dims; }
  /// Outside the lattice everything is air.
  [[nodiscard]] Kind kind(const Vec3i& brick) const;
  /// Copies the fractions of the box of side³ voxels at `lower` to `out`, x fastest.
  void gather(const Vec3i& lower, int side, float* out) const;

 private:
  [[nodiscard]] Kind classify(const Vec3i& brick) const;

  const Voxmap& voxmap_;
  const FillBricks& fill_;
  BrickLattice bricks_;
  std::vector<Kind> kinds_;
};

/// Mean density, g/cm³, of the eight voxels about `point` (voxel index space), trilinear and by weight(voxel); or 0.
template <typename Real, class Weight>
Real mean_density(const Voxmap& voxmap, const Eigen::Matrix<Real, 3, 1>& point, const Weight& weight) {
  const Eigen::Matrix<Real, 3, 1> base = point.array().floor();
  const Eigen::Matrix<Real, 3, 1> t = point - base;
  Real sum = 0, weights = 0;
  for (int i = 0; i < 8; ++i) {
    const Vec3i voxel = base.template cast<int>() + Vec3i(i & 1, i >> 1 & 1, i >> 2);
    if (!voxmap.grid.contains(voxel)) continue;
    const std::uint8_t grade = voxmap.grade.get(voxel);
    if (grade == 0) continue;
    const Real near =
        ((i & 1) ? t.x() : 1 - t.x()) * ((i >> 1 & 1) ? t.y() : 1 - t.y()) * ((i >> 2) ? t.z() : 1 - t.z());
    const Real w = near * weight(voxel);
    sum += w * static_cast<Real>(DensityMapping::density_from_grade(grade));
    weights += w;
  }
  return weights > 0 ? sum / weights : 0;
}

/// An OpenVDB grid; scalar_grid.h defines it.
struct ScalarGrid;

/// The solid as a smooth implicit field, negative inside: ½ − (bone fraction, smoothed by a Gaussian of
/// kSmoothing_voxels), which does not displace a flat face. Voxel index space: the centre of voxel (i,j,k) is (i,j,k).
class SolidField {
 public:
  static constexpr double kSmoothing_voxels = 1.0;

  explicit SolidField(const Occupancy& occupancy);

  /// Updates the field after `occupancy` was updated with the same bricks.
  void update(const Occupancy& occupancy, const std::vector<Vec3i>& bricks);

  [[nodiscard]] const ScalarGrid& grid() const { return *grid_; }
  /// The field at each of these points, interpolated linearly.
  [[nodiscard]] std::vector<float> at(std::span<const Vec3> points) const;

 private:
  void compute(const Occupancy& occupancy, const std::vector<Vec3i>& bricks);

  std::shared_ptr<ScalarGrid> grid_;
};

struct IsoSurface {
  std::vector<Eigen::Vector3f> points;
  std::vector<std::uint32_t> indices;  ///< three per triangle
};

/// The bone before a run, and the depth below its surface where its actual or predicted final state lacks bone.
struct UnreamedSurface {
  /// Fill before the run, from which depth is measured, and after it.
  UnreamedSurface(const Voxmap& voxmap, FillBricks fill_before, const FillBricks& after);

  FillBricks before;
  SolidField field;    ///< of the unreamed bone, voxel index space
  IsoSurface surface;  ///< of the unreamed bone, voxel index space; triangles counter-clockwise seen from outside
  /// Distance in mm from the reamed part of the unreamed surface, ignoring closed cavities, and holes and slits up to
  /// 3.6 mm wide (a pilot hole, a vessel); 0 where no material was removed. In the space of voxel indices times
  /// voxel_mm.
  std::shared_ptr<const ScalarGrid> depth;
  double deepest_mm;  ///< the greatest depth of the final surface; 0 when nothing is reamed
};

/// The boundary between the layers of a bone (Voxmap::layers) in a plane: at their depth, not between voxels.
class LayerBoundary {
 public:
  /// For points in the plane through three points, in voxel index space. All must outlive this.
  LayerBoundary(const Voxmap& voxmap, const UnreamedSurface& unreamed, const Vec3& a, const Vec3& b, const Vec3& c);

  /// Whether the eight voxels nearest to a point (voxel index space) are of both layers.
  [[nodiscard]] bool near(const Vec3& point) const;
  /// The density in g/cm³ at a point by its depth, blended over `blend_voxels` across the boundary.
  [[nodiscard]] double density_at(const Vec3& point, double blend_voxels) const;

 private:
  const Voxmap& voxmap_;
  std::function<double(const Vec3&)> from_surface_;  ///< distance from it near the plane; empty where there is none
};

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

}  // namespace reamsim
