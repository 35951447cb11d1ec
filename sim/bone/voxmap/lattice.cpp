#include "sim/bone/voxmap/lattice.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "sim/base/error.h"
#include "sim/bone/voxmap/sparse_bricks.h"

namespace reamsim {

namespace {

/// Share of the memory that the bone may take while it is made; the engine and the results need the rest.
constexpr double kMemoryShare = 0.5;
/// What the tables of grades and of fill take for a brick, stored or not.
constexpr double kTableBytes = 2 * sizeof(std::int32_t);
/// Bricks that the tables can number.
constexpr double kMostBricks = std::numeric_limits<std::int32_t>::max();
/// Voxels along an axis.
constexpr double kMostSide = 1e6;

/// Memory of the bricks with bone and of the tables.
double planned_bytes(double voxels, const LatticeLoad& load) {
  return voxels * (std::min(1.0, load.bone_share) * load.bytes_per_voxel + kTableBytes / FillBricks::kVoxels);
}

/// Whether a lattice can be held. False for sizes that are not numbers.
bool fits(const Eigen::Array3d& dims, const LatticeLoad& load, double memory_bytes) {
  const double voxels = dims.prod();
  return voxels >= 0 && voxels <= kMostBricks * FillBricks::kVoxels && dims.maxCoeff() < kMostSide &&
         planned_bytes(voxels, load) <= kMemoryShare * memory_bytes;
}

/// How many times as large the voxels must be for the lattice to fit. Bricks at the surface then take a larger share.
double fitting_factor(const Eigen::Array3d& dims, const LatticeLoad& load, double memory_bytes) {
  constexpr double kStep = 1.02;
  double factor = 1;
  while (!fits(dims / factor, {load.bone_share * factor, load.bytes_per_voxel}, memory_bytes)) factor *= kStep;
  return factor;
}

/// Rounded up to two digits, so that the advice holds.
std::string fitting_voxel_text(double voxel_mm) {
  const double unit = std::pow(10.0, std::floor(std::log10(voxel_mm)) - 1);
  return fmt::format("{:.3g}", std::ceil(voxel_mm / unit) * unit);
}

}  // namespace

double machine_memory_bytes() {
  return static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
}

void check_lattice(const std::string& what, const Eigen::Array3d& dims, double voxel_mm, const LatticeLoad& load,
                   double memory_bytes) {
  if (fits(dims, load, memory_bytes)) return;
  const double voxels = dims.prod();
  const std::string found = fmt::format(
      "the lattice has {:.4g} x {:.4g} x {:.4g} voxels of {:.4g} mm ({:.3g} in total) and needs {:.3g} GB; {:.3g} GB "
      "are available",
      dims.x(), dims.y(), dims.z(), voxel_mm, voxels, planned_bytes(voxels, load) / 1e9,
      kMemoryShare * memory_bytes / 1e9);
  if (!std::isfinite(voxels) || voxels < 0) throw InputError({what, 0, 0}, "", found, "give a bone of finite size");
  // 5 % more than that, because the margin does not shrink with the voxels.
  const double fitting_mm = 1.05 * voxel_mm * fitting_factor(dims, load, memory_bytes);
  throw InputError({what, 0, 0}, "", found,
                   "bone.voxel_mm of " + fitting_voxel_text(fitting_mm) + " or more would fit");
}

VoxelGrid lattice_around(const std::string& what, const Aabb& box_mm, double voxel_mm, int margin_voxels,
                         const LatticeLoad& load) {
  constexpr int kSide = FillBricks::kSide;
  // A face within a billionth of a lattice plane counts as on it, so that rounding adds no layer of voxels.
  constexpr double kOnPlane = 1e-9;
  const Eigen::Array3d first = (box_mm.min.array() / voxel_mm + kOnPlane).floor() - margin_voxels;
  const Eigen::Array3d last = (box_mm.max.array() / voxel_mm - kOnPlane).ceil() + margin_voxels;
  const Eigen::Array3d dims = ((last - first) / kSide).ceil() * kSide;
  check_lattice(what, dims, voxel_mm, load);
  return {dims.cast<int>().matrix(), voxel_mm, voxel_mm * first.matrix()};
}

}  // namespace reamsim
