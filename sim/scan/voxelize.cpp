// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/voxelize.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim/base/error.h"
#include "sim/bone/voxmap/cube_fraction.h"
#include "sim/bone/voxmap/density.h"
#include "sim/bone/voxmap/sample_voxels.h"
#include "sim/scan/aligned_image.h"
#include "sim/scan/scan.h"

namespace reamsim::ct {

namespace {

/// Air around the bone, so that its surface is closed within the lattice.
constexpr int kMarginVoxels = 4;
/// The field can be above 0 up to the next image voxel outside the bone, and up to the second where a cut passes.
constexpr int kFieldReach = 2;

struct HuStatistics {
  std::int64_t voxels = 0;
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();
  double sum = 0;

  void add(double hu) {
    ++voxels;
    sum += hu;
    least = std::min(least, hu);
    most = std::max(most, hu);
  }
};

VoxelGrid grid_of(const Lattice& image, const BoneField& bone, const BoneSettings& settings) {
  const std::string& path = settings.ct.path;
  const Vec3i reach = Vec3i::Constant(kFieldReach);
  try {
    const VoxelGrid grid = grid_around(image, bone.min - reach, bone.max + reach, settings.voxel_mm, kMarginVoxels);
    check_fits_in_memory(grid.dims.cast<double>().prod(), sizeof(std::uint8_t), path, "bone.voxel_mm");
    return grid;
  } catch (const std::length_error&) {
    throw InputError({path}, "bone.voxel_mm", "too many voxels", "use larger voxels");
  }
}

/// Whether a point lies in the image and outside the cuts. Cuts do not apply to a label map.
bool may_be_bone(const CtSettings& settings, const Aabb& image, const Vec3& point_mm) {
  const bool in_image = (point_mm.array() >= image.min.array()).all() && (point_mm.array() <= image.max.array()).all();
  return in_image && (settings.label_map || !is_cut_away(settings, point_mm));
}

/// The fraction of a voxel within the image and outside the cuts.
double remaining_fraction(const CtSettings& settings, const Aabb& image, const Vec3& center_mm, double voxel_mm) {
  double fraction = fraction_in_box(image, center_mm, voxel_mm);
  if (settings.label_map) return fraction;
  for (const CutSphereSettings& sphere : settings.cut_spheres) {
    const auto distance = [&](const Vec3& point) { return (point - sphere.center_mm).norm() - sphere.radius_mm; };
    fraction *= 1 - fraction_inside(distance, center_mm, voxel_mm);
  }
  for (const CutPlaneSettings& plane : settings.cut_planes) {
    fraction *= fraction_inside([&](const Vec3& point) { return plane.normal.dot(point - plane.point_mm); }, center_mm,
                                voxel_mm);
  }
  return fraction;
}

std::uint8_t grade_from_hu(double hu, const DensityMapping& mapping) {
  return DensityMapping::grade_from_density(mapping.density_from_hu(hu));
}

/// Number of halvings of a voxel until its parts are no larger than the voxels of the image.
int halvings(const Lattice& image, double voxel_mm) {
  constexpr double kRoundingOfLog = 1e-6;
  constexpr int kMax = 3;
  const double ratio = voxel_mm / image.spacing_mm.minCoeff();
  return std::clamp(static_cast<int>(std::ceil(std::log2(ratio) - kRoundingOfLog)), 0, kMax);
}

/// The fill follows from the zero of the field. The grade follows from the image, whose values were corrected on both
/// sides of the boundary.
void set_fill_at_surface(const BoneField& bone, const SliceResampler& hu, const CtSettings& settings, const Aabb& image,
                         FilledVoxmap& voxmap) {
  const VoxelGrid& grid = voxmap.grid;
  const int splits = halvings(bone.field.lattice, grid.voxel_mm);
  const NegatedField outside(bone.field);
  const auto sample = [&](const Vec3i& voxel, std::uint8_t grade) -> SurfaceVoxel {
    const Vec3 center = grid.center_mm(voxel);
    const double part = fraction_inside(outside, center, grid.voxel_mm, splits);
    if (part == 0) return {0, grade};
    return {part * remaining_fraction(settings, image, center, grid.voxel_mm),
            grade != 0 ? grade : grade_from_hu(hu.at(voxel), voxmap.mapping)};
  };
  set_partial_fill(sample, voxmap);
}

void note_voxmap(const FilledVoxmap& voxmap, const HuStatistics& hu, Diagnostics& report) {
  const VoxelGrid& grid = voxmap.grid;
  report.note(
      fmt::format("voxmap: {}x{}x{} voxels of {:g} mm; bone {} voxels, {:.0f} mm3; HU {:.0f} to {:.0f}, mean {:.0f}",
                  grid.dims.x(), grid.dims.y(), grid.dims.z(), grid.voxel_mm, voxmap.count_bone(), voxmap.bone_mm3(),
                  hu.least, hu.most, hu.sum / static_cast<double>(hu.voxels)));
}

}  // namespace

int resampling_reach(const Lattice& image, double voxel_mm) {
  return kFieldReach + static_cast<int>(std::ceil(voxel_mm / image.spacing_mm.minCoeff()));
}

FilledVoxmap voxelize(const AlignedImage& hu, const BoneField& bone, const BoneSettings& settings,
                      Diagnostics& report) {
  const VoxelGrid grid = grid_of(hu.lattice, bone, settings);
  FilledVoxmap voxmap(grid);
  voxmap.mapping = {settings.density.ash_slope_g_cm3_per_hu, settings.density.ash_offset_g_cm3,
                    settings.density.ash_fraction};
  voxmap.frame = "LPS";
  SliceResampler resampled(hu, grid);
  const InsideTest in_bone(bone.field, grid);
  const Aabb image = hu.lattice.bounds_mm();
  HuStatistics stats;
  DensityLimit limit(voxmap.mapping);
  for (int k = 0; k < grid.dims.z(); ++k) {
    const std::vector<double>& slice = resampled.slice(k);
    for_each_voxel({0, 0, k}, {grid.dims.x() - 1, grid.dims.y() - 1, k}, [&](const Vec3i& voxel) {
      if (!in_bone(voxel) || !may_be_bone(settings.ct, image, grid.center_mm(voxel))) return;
      const double value = slice[index_in(grid.dims, {voxel.x(), voxel.y(), 0})];
      voxmap.grade.set(voxel, grade_from_hu(value, voxmap.mapping));
      stats.add(value);
      limit.add(value, grid.voxel_mm3());
    });
  }
  if (stats.voxels == 0) {
    throw InputError({settings.ct.path}, "bone.voxel_mm", "no bone remains at this voxel size", "use smaller voxels");
  }
  if (settings.surface_voxels == SurfaceVoxels::partial)
    set_fill_at_surface(bone, resampled, settings.ct, image, voxmap);
  note_voxmap(voxmap, stats, report);
  limit.warn(settings.ct.path, report);
  return voxmap;
}

}  // namespace reamsim::ct
