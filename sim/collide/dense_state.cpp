#include "sim/collide/dense_state.h"

#include <algorithm>

#include "sim/base/error.h"
#include "sim/collide/dense_bone.h"

namespace reamsim {

DenseState make_dense_state(const cl::Device& device, const DensePlan& plan, const Voxmap& voxmap, const Tool& tool) {
  const auto at_least_one = [](std::size_t count) { return std::max<std::size_t>(1, count); };
  DenseState state;
  state.has_fill = plan.fill;
  state.bone = {device, plan.voxels, "the voxmap"};
  state.fill = {device, plan.fill ? plan.voxels : 1, "the fill of the voxmap"};
  state.claims = {device, plan.voxels / 32 + 1, "the claim bits"};
  state.codes = {device, at_least_one(plan.points), "the point shell"};
  state.points = plan.points;
  state.contacts = {device, at_least_one(plan.contacts), "the contact list"};
  state.profile = {device, make_profile_table(tool.profile, voxmap.grid.voxel_mm)};

  upload_bone(device, plan, voxmap, state);
  if (plan.points > 0) state.codes.write(device, tool.shell.codes.data(), plan.points);
  state.claims.clear(device, state.claims.count());
  return state;
}

void upload_bone(const cl::Device& device, const DensePlan& plan, const Voxmap& voxmap, DenseState& state) {
  const bool same = static_cast<std::size_t>(voxmap.grid.size()) == plan.voxels &&
                    count_unreamed(voxmap) <= plan.unreamed && (plan.fill || !partly_filled(voxmap));
  if (!same) throw RunError("this is not the bone that the engine was made for: its memory was planned for another");
  const auto grades = grades_left(voxmap);
  state.bone.write(device, grades.data(), grades.size());
  if (!plan.fill) return;
  const auto fill = dense_fill(voxmap);
  state.fill.write(device, fill.data(), fill.size());
}

}  // namespace reamsim
