// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <openvdb/openvdb.h>

#include <array>
#include <string>

#include "sim/bone/voxmap/brick_lattice.h"
#include "sim/bone/voxmap/voxel_grid.h"
#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// Signed distance of voxel centres from a closed mesh, voxels, negative inside. Near the surface it is sampled at
/// every voxel. Where a layer is many voxels thick, the distance below that is interpolated linearly between samples
/// some voxels apart: a band of all voxels down to 1.5 mm takes most of the time and the memory of loading a fine bone.
class MeshDepth {
 public:
  /// `layer_voxels`: depth to which distances are needed. Throws InputError where the mesh cannot be sampled.
  MeshDepth(const std::string& path, const TriangleMesh& mesh, const VoxelGrid& grid, double layer_voxels);

  /// Distances near the surface, by voxel; constant outside and below.
  [[nodiscard]] const openvdb::FloatTree& near_surface() const { return near_->tree(); }
  /// Whether distances below are interpolated.
  [[nodiscard]] bool interpolated() const { return ratio_ > 1; }
  /// The interpolated distance at voxel coordinates, below the surface.
  [[nodiscard]] float below(const Vec3& voxel) const;

  using Distances = std::array<float, BrickLattice::kVoxels>;
  /// The distances of a brick's voxels, by BrickLattice::offset_of().
  void of_brick(const Vec3i& brick, Distances& out) const;

 private:
  openvdb::FloatGrid::Ptr near_;
  openvdb::FloatGrid::Ptr deep_;  ///< distances in spacings of `ratio_` voxels, from the first voxel on
  int ratio_ = 1;
};

}  // namespace reamsim
