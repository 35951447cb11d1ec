#include "sim/bone/ct/voxelize.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "sim/base/error.h"
#include "sim/bone/ct/resample.h"
#include "sim/bone/ct/scan.h"
#include "sim/bone/ct/words.h"

namespace reamsim::ct {

namespace {

/// Air round the bone, so that its surface is closed within the lattice.
constexpr int kMarginVoxels = 4;
/// Between image voxels the field can be above 0 as far as the next voxel, and two where a cut passes.
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
    const VoxelGrid grid = grid_round(image, bone.min - reach, bone.max + reach, settings.voxel_mm, kMarginVoxels);
    check_fits_in_memory(grid.dims.cast<double>().prod(), sizeof(std::uint8_t), path, "bone.voxel_mm");
    return grid;
  } catch (const std::length_error&) {
    throw InputError({path}, "bone.voxel_mm", "more voxels than can be counted", "use larger voxels");
  }
}

/// Whether a point may be bone at all: in the image, and where no cut took it. A label map knows no cuts.
bool may_be_bone(const CtSettings& settings, const Aabb& image, const Vec3& point_mm) {
  const bool in_image = (point_mm.array() >= image.min.array()).all() && (point_mm.array() <= image.max.array()).all();
  return in_image && (settings.label_map || !is_cut_away(settings, point_mm));
}

void note_voxmap(const VoxelGrid& grid, const HuStatistics& hu, Report& report) {
  report.note(words("voxmap: %dx%dx%d voxels of %g mm; bone %lld voxels, %.0f mm3; HU %.0f to %.0f, mean %.0f",
                    grid.dims.x(), grid.dims.y(), grid.dims.z(), grid.voxel_mm, static_cast<long long>(hu.voxels),
                    static_cast<double>(hu.voxels) * grid.voxel_mm3(), hu.least, hu.most,
                    hu.sum / static_cast<double>(hu.voxels)));
}

}  // namespace

Voxmap voxelize(const AlignedImage& hu, const BoneField& bone, const BoneSettings& settings, Report& report) {
  const VoxelGrid grid = grid_of(hu.lattice, bone, settings);
  Voxmap voxmap(grid);
  voxmap.mapping = {settings.density.ash_slope_g_cm3_per_hu, settings.density.ash_offset_g_cm3,
                    settings.density.ash_fraction};
  voxmap.frame = "LPS";
  SliceResampler resampled(hu, grid);
  const InsideTest in_bone(bone.field, grid);
  const Aabb image = hu.lattice.bounds_mm();
  HuStatistics stats;
  for (int k = 0; k < grid.dims.z(); ++k) {
    const std::vector<double>& slice = resampled.slice(k);
    for (int j = 0; j < grid.dims.y(); ++j) {
      for (int i = 0; i < grid.dims.x(); ++i) {
        if (!in_bone(i, j, k) || !may_be_bone(settings.ct, image, grid.center_mm(i, j, k))) continue;
        const double value = slice[static_cast<std::size_t>(i + std::int64_t{grid.dims.x()} * j)];
        voxmap.grade.set({i, j, k}, DensityMapping::grade_from_density(voxmap.mapping.density_from_hu(value)));
        stats.add(value);
      }
    }
  }
  if (stats.voxels == 0) {
    throw InputError({settings.ct.path}, "bone.voxel_mm", "voxels of this size leave nothing of the bone",
                     "use smaller voxels");
  }
  note_voxmap(grid, stats, report);
  return voxmap;
}

}  // namespace reamsim::ct
