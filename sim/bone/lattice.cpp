#include "sim/bone/lattice.h"

#include <unistd.h>

#include <cmath>
#include <cstdio>

#include "sim/base/error.h"
#include "sim/bone/fill_bricks.h"

namespace reamsim {

namespace {

/// Share of the machine's memory that the grades may take; the engine and the pictures need the rest.
constexpr double kMemoryShare = 0.5;

double most_voxels() {
  const double memory_bytes =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
  return std::min(kMaxLatticeVoxels, kMemoryShare * memory_bytes);  // a byte of grade each
}

/// Rounded up to two digits, so that the advice holds.
std::string fitting_voxel_text(double voxel_mm) {
  const double unit = std::pow(10.0, std::floor(std::log10(voxel_mm)) - 1);
  char text[48];
  std::snprintf(text, sizeof text, "%.3g", std::ceil(voxel_mm / unit) * unit);
  return text;
}

}  // namespace

void check_lattice(const std::string& what, const Eigen::Array3d& dims, double voxel_mm) {
  const double voxels = dims.prod();
  const double most = most_voxels();
  if (voxels >= 0 && voxels <= most && dims.maxCoeff() < 1e6) return;
  char found[160];
  std::snprintf(found, sizeof found,
                "a lattice of %.4g x %.4g x %.4g voxels of %.4g mm (%.3g in all, at most %.3g fit)", dims.x(), dims.y(),
                dims.z(), voxel_mm, voxels, most);
  // 5 % more than the cube root asks, because the margin does not shrink with the voxels.
  const double fitting_mm = 1.05 * voxel_mm * std::max(std::cbrt(voxels / most), dims.maxCoeff() / 1e6);
  const bool known = std::isfinite(fitting_mm) && fitting_mm > 0;
  throw InputError({what, 0, 0}, "", found,
                   known ? "bone.voxel_mm of " + fitting_voxel_text(fitting_mm) + " or more would fit"
                         : "expected a bone of finite size");
}

VoxelGrid lattice_around(const std::string& what, const Aabb& box_mm, double voxel_mm, int margin_voxels) {
  constexpr int kSide = FillBricks::kSide;
  // A face within a billionth of a lattice plane counts as on it, so that rounding adds no layer of voxels.
  constexpr double kOnPlane = 1e-9;
  const Eigen::Array3d first = (box_mm.min.array() / voxel_mm + kOnPlane).floor() - margin_voxels;
  const Eigen::Array3d last = (box_mm.max.array() / voxel_mm - kOnPlane).ceil() + margin_voxels;
  const Eigen::Array3d dims = ((last - first) / kSide).ceil() * kSide;
  check_lattice(what, dims, voxel_mm);
  return {dims.cast<int>().matrix(), voxel_mm, voxel_mm * first.matrix()};
}

}  // namespace reamsim
