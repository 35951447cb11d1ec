#include "sim/engine/dense/dense_state.h"

#include <algorithm>
#include <array>

#include "sim/base/error.h"
#include "sim/engine/common/dense_bone.h"

namespace reamsim {

namespace {

/// Writes the HU that stand for these grades, a piece at a time: all of them would be four times the grades again.
void upload_hu(const cl::Device& device, const std::vector<std::uint8_t>& grades, const HuScale& scale,
               cl::Buffer<cl_float>& hu) {
  constexpr std::size_t kPiece = std::size_t{1} << 22;
  std::array<cl_float, 256> hu_of_grade{};
  for (int g = 0; g < 256; ++g) {
    hu_of_grade[static_cast<std::size_t>(g)] = scale.hu(static_cast<std::uint8_t>(g));
  }
  std::vector<cl_float> piece;
  for (std::size_t begin = 0; begin < grades.size(); begin += kPiece) {
    const std::size_t end = std::min(grades.size(), begin + kPiece);
    piece.clear();
    for (std::size_t e = begin; e < end; ++e) piece.push_back(hu_of_grade[grades[e]]);
    hu.write(device, piece.data(), piece.size(), begin);
  }
}

}  // namespace

DenseState make_dense_state(const cl::Device& device, const DensePlan& plan, const BoneView& bone, const Tool& tool) {
  const auto at_least_one = [](std::size_t count) { return std::max<std::size_t>(1, count); };
  DenseState state;
  state.has_fill = plan.fill;
  if (plan.layout == VoxelLayout::flagged_hu) {
    state.scale = HuScale(bone.voxmap.mapping);
    if (!state.scale.exact()) {
      throw InputError({}, "bone.density", "found a mapping whose HU a float rounds to more than a grade",
                       "another mapping, or another engine.detector than octree, which keeps HU");
    }
    state.hu = {device, plan.voxels, "the voxmap"};
  } else {
    state.grades = {device, plan.voxels, "the voxmap"};
  }
  state.fill = {device, plan.fill ? plan.voxels : 1, "the fill of the voxmap"};
  state.claims = {device, at_least_one(plan.claim_bytes() / sizeof(cl_uint)), "the voxels' claims"};
  state.contacts = {device, at_least_one(plan.contacts), "the contact list"};
  state.profile = {device, make_profile_table(tool.profile, bone.voxmap.grid.voxel_mm)};

  upload_bone(device, plan, bone, state);
  state.claims.clear(device, state.claims.count());
  return state;
}

void upload_bone(const cl::Device& device, const DensePlan& plan, const BoneView& bone, DenseState& state) {
  const bool same = static_cast<std::size_t>(bone.voxmap.grid.size()) == plan.voxels &&
                    static_cast<std::size_t>(bone.voxmap.grade.count()) <= plan.unreamed &&
                    (plan.fill || !partly_filled(bone.fill));
  if (!same) throw RunError("this is not the bone for which the engine was created");
  const auto grades = dense_remaining_grades(bone);
  if (plan.layout == VoxelLayout::flagged_hu) {
    upload_hu(device, grades, state.scale, state.hu);
  } else {
    state.grades.write(device, grades.data(), grades.size());
  }
  if (!plan.fill) return;
  const auto fill = dense_fill(bone);
  state.fill.write(device, fill.data(), fill.size());
}

}  // namespace reamsim
