// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/phantom.h"

#include <fmt/core.h>
#include <cmath>
#include <numbers>

#include "sim/base/error.h"
#include "sim/bone/voxmap/cube_fraction.h"
#include "sim/bone/voxmap/sample_voxels.h"

namespace reamsim {

namespace {

bool sample_brick(const VoxelGrid& grid, const DensityField& field, const Vec3i& brick_coord, GradeBricks::Brick& out) {
  const Vec3i first = GradeBricks::kSide * brick_coord;
  const Vec3i last = (first + Vec3i::Constant(GradeBricks::kSide)).cwiseMin(grid.dims);
  bool any = false;
  for_each_voxel(first, last - Vec3i::Ones(), [&](const Vec3i& voxel) {
    const double density = field(grid.center_mm(voxel));
    if (density < 0) return;
    out[static_cast<std::size_t>(BrickLattice::offset_of(voxel))] = DensityMapping::grade_from_density(density);
    any = true;
  });
  return any;
}

// Verification blocks have closed-form surfaces. Lattice planes lie at multiples of the voxel size, so that a top face
// at z = 0 lies between two layers of voxels. The glenoid frame is at the centre of the top face, +z up.

GlenoidFrame frame_of_block(const Vec3& origin_mm) {
  GlenoidFrame frame;
  frame.bone_from_glenoid.translation() = origin_mm;
  return frame;
}

/// A block centred on the z axis. `carved`: a solid that is removed from it, negative inside.
Bone make_block(const BoneSettings& settings, const DensityField& density_in_block,
                const std::function<double(const Vec3&)>& carved = {}) {
  const Vec3& size = settings.phantom.size_mm;
  const Aabb box{{-size.x() / 2, -size.y() / 2, -size.z()}, {size.x() / 2, size.y() / 2, 0}};
  const VoxelGrid grid = lattice_around("bone.phantom.size_mm", box, settings.voxel_mm, kMarginVoxels);
  const auto density = [&](const Vec3& point) {
    const bool inside = (point.array() >= box.min.array()).all() && (point.array() <= box.max.array()).all();
    return inside && !(carved && carved(point) < 0) ? density_in_block(point) : kAir;
  };
  PartialField partial;
  if (settings.surface_voxels == SurfaceVoxels::partial) {
    partial = [&](const Vec3& center) -> PartialVoxel {
      const double fraction = carved ? 1 - fraction_inside(carved, center, grid.voxel_mm) : 1;
      return {fraction * fraction_in_box(box, center, grid.voxel_mm),
              density_in_block(center.cwiseMax(box.min).cwiseMin(box.max))};
    };
  }
  return Bone(sample_phantom(grid, settings.density, density, partial), frame_of_block(Vec3::Zero()));
}

/// The block with a spherical cup of `radius_mm`, `cup_depth_mm` deep, in the middle of its top face.
Bone cup_phantom(const BoneSettings& settings, const DensityField& density) {
  const PhantomSettings& phantom = settings.phantom;
  const Vec3 center(0, 0, phantom.radius_mm - phantom.cup_depth_mm);
  const double radius2 = phantom.radius_mm * phantom.radius_mm;
  Bone bone =
      make_block(settings, density, [=](const Vec3& point) { return (point - center).squaredNorm() - radius2; });
  const double opening_mm = std::sqrt(std::max(radius2 - center.z() * center.z(), 0.0));
  constexpr int kRimPoints = 120;
  for (int i = 0; i < kRimPoints; ++i) {
    const double angle = 2 * std::numbers::pi * i / kRimPoints;
    bone.rim_mm.emplace_back(opening_mm * std::cos(angle), opening_mm * std::sin(angle), 0);
  }
  return bone;
}

/// A sphere about the origin; the glenoid frame is at its pole (0, 0, radius).
Bone sphere_phantom(const BoneSettings& settings) {
  const double radius = settings.phantom.radius_mm;
  const Aabb box{Vec3::Constant(-radius), Vec3::Constant(radius)};
  const VoxelGrid grid = lattice_around("bone.phantom.radius_mm", box, settings.voxel_mm, kMarginVoxels);
  const double density = settings.phantom.density_g_cm3;
  const auto field = [=](const Vec3& point) { return point.squaredNorm() <= radius * radius ? density : kAir; };
  PartialField partial;
  if (settings.surface_voxels == SurfaceVoxels::partial) {
    partial = [=](const Vec3& voxel) -> PartialVoxel {
      const auto distance = [radius](const Vec3& point) { return point.norm() - radius; };
      return {fraction_inside(distance, voxel, grid.voxel_mm), density};
    };
  }
  return Bone(sample_phantom(grid, settings.density, field, partial), frame_of_block({0, 0, radius}));
}

}  // namespace

DensityMapping mapping_from(const DensitySettings& density) {
  return {density.ash_slope_g_cm3_per_hu, density.ash_offset_g_cm3, density.ash_fraction};
}

FilledVoxmap sample_phantom(const VoxelGrid& grid, const DensitySettings& density, const DensityField& field,
                            const PartialField& partial, const AirTest& all_air) {
  FilledVoxmap voxmap(grid);
  voxmap.mapping = mapping_from(density);
  voxmap.frame = "phantom";
  const double radius_mm = 0.5 * GradeBricks::kSide * grid.voxel_mm * std::numbers::sqrt3;
  voxmap.grade = sample_bricks(grid.dims, [&](const Vec3i& coord, GradeBricks::Brick& brick) {
    const Vec3 center_mm =
        grid.origin_mm + GradeBricks::kSide * grid.voxel_mm * (coord.cast<double>() + Vec3::Constant(0.5));
    return !all_air(center_mm, radius_mm) && sample_brick(grid, field, coord, brick);
  });
  if (!partial) return voxmap;
  const auto sample = [&](const Vec3i& voxel, std::uint8_t grade) -> SurfaceVoxel {
    const PartialVoxel found = partial(grid.center_mm(voxel));
    return {found.fraction, grade != 0 ? grade : DensityMapping::grade_from_density(found.density_g_cm3)};
  };
  set_partial_fill(sample, voxmap);
  return voxmap;
}

void fail_phantom(const std::string& key, double found_mm, const std::string& expected) {
  throw InputError({}, "bone.phantom." + key, fmt::format("{:.4g} mm", found_mm), expected);
}

Bone bone_from_phantom(const BoneSettings& settings, Diagnostics& report) {
  const PhantomShape shape = settings.phantom.shape;
  report.note("phantom: " + name_of(shape));
  const auto uniform = [density = settings.phantom.density_g_cm3](const Vec3&) { return density; };
  if (shape == PhantomShape::half_space) return make_block(settings, uniform);
  if (shape == PhantomShape::cup) return cup_phantom(settings, uniform);
  if (shape == PhantomShape::sphere) return sphere_phantom(settings);
  if (shape == PhantomShape::layered) {
    return make_block(settings, [phantom = settings.phantom](const Vec3& point) {
      return point.z() > -phantom.cortical_mm ? phantom.cortical_density_g_cm3 : phantom.trabecular_density_g_cm3;
    });
  }
  return glenoid_phantom(settings, report);
}

}  // namespace reamsim
