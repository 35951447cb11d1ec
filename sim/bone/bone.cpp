// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/bone.h"

#include <utility>

#include "sim/base/error.h"
#include "sim/bone/voxmap/lattice.h"
#include "sim/bone/voxmap/sample_voxels.h"

namespace reamsim {

namespace {

/// Whether any of the 8×8×8 voxels from `first` on lies in a stored brick.
bool any_stored(const GradeBricks& from, const Vec3i& first) {
  const BrickLattice bricks{from.brick_dims()};
  const Vec3i last = first + Vec3i::Constant(GradeBricks::kSide - 1);
  bool any = false;
  for_each_voxel(BrickLattice::brick_of(first), BrickLattice::brick_of(last),
                 [&](const Vec3i& brick) { any = any || (bricks.contains(brick) && from.brick(brick) != nullptr); });
  return any;
}

/// Copies to a brick of the shifted lattice. Its voxel (0,0,0) is voxel `shift` of `from`.
bool copy_brick(const Voxmap& from, const Vec3i& shift, const Vec3i& brick_coord, GradeBricks::Brick& out) {
  const Vec3i first = GradeBricks::kSide * brick_coord + shift;
  if (!any_stored(from.grade, first)) return false;
  bool any = false;
  for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
    const Vec3i voxel = BrickLattice::voxel_at(brick_coord, offset) + shift;
    if (!from.grid.contains(voxel)) continue;
    const std::uint8_t grade = from.grade.get(voxel);
    out[static_cast<std::size_t>(offset)] = grade;
    any = any || grade != 0;
  }
  return any;
}

void copy_fill_within(const VoxelBox& box, const FillBricks& from, const Vec3i& shift, FillBricks& to) {
  from.for_each_brick([&](const Vec3i& coord, const FillBricks::Brick& fill) {
    for (int offset = 0; offset < FillBricks::kVoxels; ++offset) {
      const Vec3i voxel = BrickLattice::voxel_at(coord, offset);
      if (!box.contains(voxel)) continue;
      to.set(voxel - shift, fill[static_cast<std::size_t>(offset)]);
    }
  });
}

}  // namespace

void Bone::set_voxels(FilledVoxmap&& voxels) {
  fill = std::move(voxels.fill);
  voxmap = std::make_shared<Voxmap>(std::move(static_cast<Voxmap&>(voxels)));
}

FilledVoxmap Bone::copy_voxels() const {
  FilledVoxmap out;
  static_cast<Voxmap&>(out) = *voxmap;
  out.fill = fill;
  return out;
}

FilledVoxmap fit_to_bone(const BoneView& bone, int margin_voxels) {
  const Voxmap& voxmap = bone.voxmap;
  const VoxelBox extent = bone_extent(voxmap);
  if (extent.empty()) {
    throw InputError({}, "bone", "the volume contains no bone", "expected at least one voxel of bone");
  }
  const Vec3i shift = extent.first - Vec3i::Constant(margin_voxels);
  const Vec3i needed = extent.last - extent.first + Vec3i::Constant(1 + 2 * margin_voxels);
  const Vec3i dims = (needed.array() + (FillBricks::kSide - 1)) / FillBricks::kSide * FillBricks::kSide;
  const double most_voxels = 2.0 * GradeBricks::kVoxels * static_cast<double>(voxmap.grade.stored_bricks());
  const Eigen::Array3d size = dims.cast<double>().array();
  check_lattice("bone", size, voxmap.grid.voxel_mm, {.bone_fraction = most_voxels / size.prod()});

  const VoxelGrid& from = voxmap.grid;
  FilledVoxmap out;
  out.grid = {dims, from.voxel_mm, from.origin_mm + from.voxel_mm * shift.cast<double>()};
  out.grade = sample_bricks(dims, [&](const Vec3i& brick_coord, GradeBricks::Brick& brick) {
    return copy_brick(voxmap, shift, brick_coord, brick);
  });
  out.fill = FillBricks(dims);
  copy_fill_within(extent, bone.fill, shift, out.fill);
  out.mapping = voxmap.mapping;
  out.layers = voxmap.layers;
  out.frame = voxmap.frame;
  return out;
}

}  // namespace reamsim
