// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/voxmap/voxel_grid.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <limits>

#include "sim/base/error.h"
#include "sim/bone/voxmap/sparse_bricks.h"

namespace reamsim {

namespace {

/// Fraction of the memory for building the bone. The engine and the results need the rest.
constexpr double kMemoryFraction = 0.5;
/// Entries of a brick, stored or not, in the tables of grades and of fill.
constexpr double kTableBytes = 2 * sizeof(std::int32_t);
constexpr double kMaxBricks = std::numeric_limits<std::int32_t>::max();
constexpr double kMaxSide = 1e6;  // voxels along an axis

double planned_bytes(double voxels, const LatticeLoad& load) {
  return voxels * (std::min(1.0, load.bone_fraction) * load.bytes_per_voxel + kTableBytes / FillBricks::kVoxels);
}

/// False for sizes that are NaN.
bool fits(const Eigen::Array3d& dims, const LatticeLoad& load, double memory_bytes) {
  const double voxels = dims.prod();
  return voxels >= 0 && voxels <= kMaxBricks * FillBricks::kVoxels && dims.maxCoeff() < kMaxSide &&
         planned_bytes(voxels, load) <= kMemoryFraction * memory_bytes;
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
      kMemoryFraction * memory_bytes / 1e9);
  if (!std::isfinite(voxels) || voxels < 0) throw InputError({what, 0, 0}, "", found, "give a bone of finite size");
  constexpr double kStep = 1.02;
  double factor = 1;  // by which the voxels must grow; the fraction of bricks at the surface grows with it
  while (!fits(dims / factor, {load.bone_fraction * factor, load.bytes_per_voxel}, memory_bytes)) factor *= kStep;
  // 5 % more, because the margin in mm grows with the voxels; rounded up to two digits.
  const double fitting_mm = 1.05 * voxel_mm * factor;
  const double unit = std::pow(10.0, std::floor(std::log10(fitting_mm)) - 1);
  throw InputError({what, 0, 0}, "", found,
                   fmt::format("bone.voxel_mm of {:.3g} or more would fit", std::ceil(fitting_mm / unit) * unit));
}

VoxelGrid lattice_around(const std::string& what, const Aabb& box_mm, double voxel_mm, int margin_voxels,
                         const LatticeLoad& load) {
  constexpr int kSide = FillBricks::kSide;
  // A face this close to a lattice plane, in voxels, lies on it: rounding must not add a layer of voxels.
  constexpr double kOnPlane = 1e-9;
  const Eigen::Array3d first = (box_mm.min.array() / voxel_mm + kOnPlane).floor() - margin_voxels;
  const Eigen::Array3d last = (box_mm.max.array() / voxel_mm - kOnPlane).ceil() + margin_voxels;
  const Eigen::Array3d dims = ((last - first) / kSide).ceil() * kSide;
  check_lattice(what, dims, voxel_mm, load);
  return {dims.cast<int>().matrix(), voxel_mm, voxel_mm * first.matrix()};
}

}  // namespace reamsim
