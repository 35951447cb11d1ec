// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/dense/dense_state.h"

#include <fmt/core.h>
#include <bit>

#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/tool/point_shell.h"

namespace reamsim {

namespace {

/// Size of the list of removed voxels; larger scenes read results back more often.
constexpr std::size_t kRemovedRoom = 4'000'000;

constexpr std::size_t kMaxVoxels = std::size_t{1} << 32;

/// Bound of the number of voxels with centres in the tool, in any pose: the volume of the tool's box, extended by half
/// a voxel's diagonal on every side.
std::size_t voxels_in_tool(const Profile& profile, double voxel_mm) {
  const Aabb box = profile.bounds();
  const Vec3 grown = (box.max - box.min) / voxel_mm + Vec3::Constant(std::sqrt(3.0));
  return static_cast<std::size_t>(std::ceil(std::min(grown.prod(), static_cast<double>(kMaxVoxels))));
}

std::vector<cl_uint> code_words(const PointShell& shell, bool wide) {
  std::vector<cl_uint> words;
  words.reserve(shell.codes.size() * (wide ? 2 : 1));
  for (const std::uint64_t code : shell.codes) {
    words.push_back(static_cast<cl_uint>(code));
    if (wide) words.push_back(static_cast<cl_uint>(code >> 32));
  }
  return words;
}

void upload_shell(const cl::Device& device, const DensePlan& plan, const PointShell& shell, const VoxelGrid& grid,
                  DenseState& state) {
  state.point_count = static_cast<cl_uint>(plan.points);
  if (plan.layout == VoxelLayout::claimed_grade)
    state.codes = cl::upload(device, code_words(shell, plan.wide_codes), "the point shell", "tool.shell_resolution");
  if (!plan.has_hu()) return;
  state.points = cl::upload(device, cell_numbers(shell), "the point shell", "tool.shell_resolution");
  state.children = cl::upload(device, octree_children(grid), "the look-up tables");
  state.levels = octree_levels(grid);
}

}  // namespace

DensePlan plan_dense(EngineKind engine, const BoneView& bone, const Tool& tool, bool wear) {
  DensePlan plan;
  if (engine == EngineKind::octree) plan.layout = VoxelLayout::flagged_hu;
  if (engine == EngineKind::implicit) plan.layout = VoxelLayout::bare_grade;
  const bool has_shell = plan.layout != VoxelLayout::bare_grade;
  plan.voxels = static_cast<std::size_t>(bone.voxmap.grid.size());
  plan.bone_voxels = static_cast<std::size_t>(bone.voxmap.grade.count());
  plan.points = has_shell ? tool.shell.codes.size() : 0;
  plan.wide_codes = tool.shell.resolution > kNarrowResolution;
  plan.fill = wear || partly_filled(bone.fill);
  plan.contacts =
      std::min(plan.bone_voxels, has_shell ? plan.points : voxels_in_tool(tool.profile, bone.voxmap.grid.voxel_mm));
  plan.removed = std::min(plan.bone_voxels, std::max(kRemovedRoom, plan.contacts));
  return plan;
}

void require_fit(const DensePlan& plan, const cl::DeviceInfo& device, double voxel_mm) {
  const auto fraction = [](std::size_t need, std::size_t have) {
    return static_cast<double>(need) / static_cast<double>(std::max<std::size_t>(1, have));
  };
  const double most = std::max({fraction(plan.voxels, kMaxVoxels), fraction(plan.bytes(), device.global_memory_bytes),
                                fraction(plan.largest_bytes(), device.max_allocation_bytes)});
  if (most <= 1) return;
  // Memory is inversely proportional to the cube of the voxel size; the margin covers the rounding to whole voxels.
  constexpr double kMargin = 1.02;
  const std::string fits =
      fmt::format("a bone.voxel_mm of about {:.3g} or more would fit", voxel_mm * std::cbrt(most) * kMargin);
  throw InputError({}, "bone.voxel_mm",
                   "found a voxmap of " + std::to_string(plan.voxels) + " voxels; a dense engine supports at most " +
                       std::to_string(kMaxVoxels) + "; it needs " + megabytes(plan.bytes()) + " on the device and " +
                       megabytes(plan.largest_bytes()) + " of it in one allocation; " + device.name + " has " +
                       megabytes(device.global_memory_bytes) + " in total and at most " +
                       megabytes(device.max_allocation_bytes) + " in one allocation",
                   fits + ", or engine.type: bricked, which stores only bricks with bone");
}

void upload_hu(const cl::Device& device, const std::vector<std::uint8_t>& grades, const HuScale& scale,
               cl::Buffer<cl_float>& hu) {
  constexpr std::size_t kPiece = std::size_t{1} << 22;
  std::vector<cl_float> piece;
  for (std::size_t begin = 0; begin < grades.size(); begin += kPiece) {
    const std::size_t end = std::min(grades.size(), begin + kPiece);
    piece.clear();
    for (std::size_t e = begin; e < end; ++e) piece.push_back(scale.hu(grades[e]));
    hu.write(device, piece.data(), piece.size(), begin);
  }
}

std::vector<cl_float> cell_numbers(const PointShell& shell) {
  std::vector<cl_float> out;
  out.reserve(3 * shell.codes.size());
  for (const std::uint64_t code : shell.codes) {
    const Vec3i cell = morton_decode(code);
    for (int axis = 0; axis < 3; ++axis) out.push_back(static_cast<cl_float>(cell[axis]));
  }
  return out;
}

bool HuScale::exact() const {
  for (int g = 0; g <= 255; ++g) {
    const auto value = static_cast<std::uint8_t>(g);
    if (grade(hu(value)) != g || (g > 0) != (hu(value) > of_air)) return false;
  }
  return true;
}

DenseState make_dense_state(const cl::Device& device, const DensePlan& plan, const BoneView& bone, const Tool& tool,
                            const EnergyTable& energy) {
  const auto at_least_one = [](std::size_t count) { return std::max<std::size_t>(1, count); };
  DenseState state;
  state.has_fill = plan.fill;
  if (plan.has_hu()) {
    state.scale = HuScale(bone.voxmap.mapping);
    if (!state.scale.exact()) {
      throw InputError({}, "bone.density", "found a mapping whose HU a float rounds to more than a grade",
                       "another mapping, or another engine.type than octree, which keeps HU");
    }
    state.hu = {device, plan.voxels, "the voxmap"};
  } else {
    state.grades = {device, plan.voxels, "the voxmap"};
  }
  state.fill = {device, plan.fill ? plan.voxels : 1, "the fill of the voxmap"};
  state.claims = {device, at_least_one(plan.claim_bytes() / sizeof(cl_uint)), "the voxels' claims"};
  state.contacts = {device, at_least_one(plan.contacts), "the contact list"};
  state.outline = upload_outline(device, make_outline_table(tool.profile, bone.voxmap.grid.voxel_mm));
  state.units_of_grade = cl::upload(device, energy.units, "the energy table");
  state.density_of_grade = cl::upload(device, energy.density, "the density table");
  upload_shell(device, plan, tool.shell, bone.voxmap.grid, state);
  upload_bone(device, plan, bone, state);
  state.claims.clear(device, state.claims.count());
  return state;
}

void upload_bone(const cl::Device& device, const DensePlan& plan, const BoneView& bone, DenseState& state) {
  const bool same = static_cast<std::size_t>(bone.voxmap.grid.size()) == plan.voxels &&
                    static_cast<std::size_t>(bone.voxmap.grade.count()) <= plan.bone_voxels &&
                    (plan.fill || !partly_filled(bone.fill));
  if (!same) throw RunError("this is not the bone for which the engine was created");
  const auto grades = dense_remaining_grades(bone);
  if (plan.has_hu()) {
    upload_hu(device, grades, state.scale, state.hu);
  } else {
    state.grades.write(device, grades.data(), grades.size());
  }
  if (!plan.fill) return;
  const auto fill = dense_fill(bone);
  state.fill.write(device, fill.data(), fill.size());
}

int octree_levels(const VoxelGrid& grid) {
  return static_cast<int>(std::bit_width(static_cast<unsigned>(grid.dims.maxCoeff() - 1)));
}

std::vector<cl_uint4> octree_children(const VoxelGrid& grid) {
  std::vector<cl_uint4> children;
  const int levels = octree_levels(grid);
  for (int level = 0; level < levels; ++level) {
    const std::int64_t half_side = std::int64_t{1} << (levels - 1 - level);
    for (int octant = 0; octant < 8; ++octant) {
      const std::int64_t x = (octant & 1) * half_side, y = (octant >> 1 & 1) * half_side, z = (octant >> 2) * half_side;
      // The step of an octant outside the lattice is meaningless; no point descends into it.
      const std::int64_t step = x + grid.dims.x() * (y + grid.dims.y() * z);
      children.push_back(
          {{static_cast<cl_uint>(x), static_cast<cl_uint>(y), static_cast<cl_uint>(z), static_cast<cl_uint>(step)}});
    }
  }
  return children;
}

}  // namespace reamsim
