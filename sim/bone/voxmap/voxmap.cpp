// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/voxmap/voxmap.h"

#include <fmt/core.h>
#include <unistd.h>
#include <limits>

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

/// Cortical bone reaches 2000 HU, enamel 3000. Scanners with 12 bits end at 3071, where metal then is.
constexpr double kMetal_hu = 3000;
/// Less bone than this changes no force noticeably: noise, and the densest spots of a cortex.
constexpr double kLeast_mm3 = 1;
constexpr double kLeastFraction = 1e-3;  // the same, as a fraction of the bone

template <class Value>
std::int64_t sum_over_bone(const BoneView& bone, const Value& value) {
  std::int64_t sum = 0;
  bone.voxmap.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick& grades) {
    const FillBricks::Brick* fill = bone.fill.brick(coord);
    if (fill == nullptr) {
      sum += value(FillBricks::kWhole) * (GradeBricks::kVoxels - std::ranges::count(grades, 0));
      return;
    }
    for (std::size_t i = 0; i < grades.size(); ++i) sum += grades[i] != 0 ? value((*fill)[i]) : 0;
  });
  return sum;
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

void DensityLimit::add(double hu, double mm3) {
  bone_mm3_ += mm3;
  if (hu > limit_hu_) denser_mm3_ += mm3;
  if (hu > kMetal_hu) metal_mm3_ += mm3;
}

void DensityLimit::warn(const std::string& path, Diagnostics& report) const {
  const bool metal = metal_mm3_ >= kLeast_mm3;
  if (!metal && (denser_mm3_ < kLeast_mm3 || denser_mm3_ < kLeastFraction * bone_mm3_)) return;
  std::string text = path + ": ";
  if (denser_mm3_ > 0) {
    text += fmt::format(
        "{:.0f} mm3 of the bone is denser than {:g} g/cm3 ({:.0f} HU), the most that is represented; forces there are "
        "too small",
        denser_mm3_, DensityMapping::kMaxDensity_g_cm3, limit_hu_);
  }
  if (metal) {
    text += fmt::format("{}{:.0f} mm3 is above {:.0f} HU: is it metal? crop or cut it", denser_mm3_ > 0 ? "; " : "",
                        metal_mm3_, kMetal_hu);
  }
  report.warn(text);
}

void warn_of_density_limit(const DensityMapping& mapping, const std::string& key, double hu, Diagnostics& report) {
  const double limit_hu = mapping.limit_hu();
  if (hu <= limit_hu) return;
  report.warn(
      fmt::format("{} is {:g} HU, denser than {:g} g/cm3 ({:.0f} HU), the most that is represented; forces there are "
                  "those of {:g} g/cm3",
                  key, hu, DensityMapping::kMaxDensity_g_cm3, limit_hu, DensityMapping::kMaxDensity_g_cm3));
}

std::int64_t BoneView::count_bone() const {
  return sum_over_bone(*this, [](std::uint16_t value) { return std::int64_t{value != 0 ? 1 : 0}; });
}

double BoneView::bone_mm3() const {
  // In 1/65535 of a voxel: integers, so that the order of summation does not matter.
  const std::int64_t sum = sum_over_bone(*this, [](std::uint16_t value) { return std::int64_t{value}; });
  return static_cast<double>(sum) / FillBricks::kWhole * voxmap.grid.voxel_mm3();
}

VoxelBox bone_extent(const Voxmap& voxmap) {
  VoxelBox out{voxmap.grid.dims, Vec3i::Constant(-1)};
  voxmap.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick& grades) {
    const Vec3i first = GradeBricks::kSide * coord;
    if (out.contains(first) && out.contains(first + Vec3i::Constant(GradeBricks::kSide - 1))) return;
    for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
      if (grades[static_cast<std::size_t>(offset)] == 0) continue;
      const Vec3i voxel = BrickLattice::voxel_at(coord, offset);
      out.first = out.first.cwiseMin(voxel);
      out.last = out.last.cwiseMax(voxel);
    }
  });
  return out;
}

std::vector<Vec3i> bricks_near_bone(const GradeBricks& grades) {
  const BrickLattice wider{grades.brick_dims() + Vec3i::Constant(2)};
  std::vector<bool> near(wider.count(), false);
  grades.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick&) {
    for (int z = 0; z < 3; ++z) {
      for (int y = 0; y < 3; ++y) {
        const std::size_t row = wider.index(coord + Vec3i(0, y, z));
        for (std::size_t x = 0; x < 3; ++x) near[row + x] = true;
      }
    }
  });
  std::vector<Vec3i> out;
  for (std::size_t i = 0; i < near.size(); ++i) {
    if (near[i]) out.emplace_back(wider.coord(i) - Vec3i::Ones());
  }
  return out;
}

bool partly_filled(const FillBricks& fill) {
  const auto is_part = [](std::uint16_t value) { return value != 0 && value != FillBricks::kWhole; };
  bool part = false;
  fill.for_each_brick([&](const Vec3i&, const auto& brick) { part = part || std::ranges::any_of(brick, is_part); });
  return part;
}

void gather_fractions(const BoneView& bone, const Vec3i& lower, int side, float* out) {
  constexpr float kPerFillUnit = 1.0F / FillBricks::kWhole;
  std::fill(out, out + static_cast<std::ptrdiff_t>(side) * side * side, 0.0F);
  const Vec3i first = lower.cwiseMax(0);
  const Vec3i last = (lower.array() + side).min(bone.voxmap.grid.dims.array()) - 1;
  for_each_voxel(BrickLattice::brick_of(first), BrickLattice::brick_of(last), [&](const Vec3i& brick) {
    const GradeBricks::Brick* grades = bone.voxmap.grade.brick(brick);
    if (grades == nullptr) return;
    const FillBricks::Brick* fill = bone.fill.brick(brick);
    const Vec3i from = first.cwiseMax(brick * FillBricks::kSide);
    const Vec3i to = (last.array()).min(brick.array() * FillBricks::kSide + FillBricks::kSide - 1);
    for_each_voxel(from, to, [&](const Vec3i& voxel) {
      const auto offset = static_cast<std::size_t>(BrickLattice::offset_of(voxel));
      if ((*grades)[offset] == 0) return;
      const Vec3i at = voxel - lower;
      out[at.x() + side * (at.y() + side * at.z())] = fill ? kPerFillUnit * static_cast<float>((*fill)[offset]) : 1.0F;
    });
  });
}

std::vector<std::uint8_t> dense_remaining_grades(const BoneView& bone) {
  std::vector<std::uint8_t> out(static_cast<std::size_t>(bone.voxmap.grid.size()), 0);
  for_each_bone_voxel(bone, [&](const Vec3i& voxel, std::uint8_t grade, std::uint16_t fill) {
    if (fill != 0) out[static_cast<std::size_t>(bone.voxmap.grid.index(voxel))] = grade;
  });
  return out;
}

std::vector<std::uint16_t> dense_fill(const BoneView& bone) {
  std::vector<std::uint16_t> out(static_cast<std::size_t>(bone.voxmap.grid.size()), FillBricks::kWhole);
  bone.fill.for_each_brick([&](const Vec3i& coord, const FillBricks::Brick& fill) {
    for (int offset = 0; offset < FillBricks::kVoxels; ++offset) {
      const Vec3i voxel = BrickLattice::voxel_at(coord, offset);
      if (!bone.voxmap.grid.contains(voxel)) continue;
      out[static_cast<std::size_t>(bone.voxmap.grid.index(voxel))] = fill[static_cast<std::size_t>(offset)];
    }
  });
  return out;
}

}  // namespace reamsim
