#include "sim/collide/device_state.h"

#include <algorithm>
#include <cmath>

#include "sim/base/error.h"

namespace reamsim {

namespace {

/// Room for removed voxels that a batch may fill; larger scenes read results back more often instead.
constexpr std::int64_t kRemovedRoom = 4'000'000;

std::size_t contact_room(std::int64_t bone_voxels, const PointShell& shell) {
  return static_cast<std::size_t>(std::min<std::int64_t>(bone_voxels, std::ssize(shell.codes)));
}

std::size_t removed_room(std::int64_t bone_voxels, const PointShell& shell) {
  const auto one_substep = static_cast<std::int64_t>(contact_room(bone_voxels, shell));
  return static_cast<std::size_t>(std::min(bone_voxels, std::max(kRemovedRoom, one_substep)));
}

bool needs_fill(const Voxmap& voxmap, bool wear) {
  return wear || voxmap.fill.stored_bricks() > 0;
}

}  // namespace

std::size_t device_bytes(const Voxmap& voxmap, const PointShell& shell, bool wear) {
  const auto voxels = static_cast<std::size_t>(voxmap.grid.size());
  const std::int64_t bone = voxmap.count_bone();
  return voxels + (needs_fill(voxmap, wear) ? 2 * voxels : 0) + voxels / 8 + 4 * shell.codes.size() +
         4 * contact_room(bone, shell) + sizeof(RemovedVoxel) * removed_room(bone, shell) +
         kMaxSlots * (sizeof(SubstepArgs) + sizeof(SubstepSums) + sizeof(cl_uint));
}

DeviceState make_device_state(const cl::Device& device, const Voxmap& voxmap, const Tool& tool, bool wear) {
  const auto voxels = static_cast<std::size_t>(voxmap.grid.size());
  const std::size_t need = device_bytes(voxmap, tool.shell, wear), have = device.info().global_memory_bytes;
  if (voxels > UINT32_MAX || need > have) {
    const double factor = std::cbrt(static_cast<double>(std::max(need, voxels)) /
                                    static_cast<double>(std::min<std::size_t>(have, UINT32_MAX)));
    throw InputError({}, "bone.voxel_mm",
                     "the bone has " + std::to_string(voxels) + " voxels and needs " +
                         std::to_string(need / 1'000'000) + " MB of the " + std::to_string(have / 1'000'000) +
                         " MB of " + device.info().name,
                     "about " + std::to_string(voxmap.grid.voxel_mm * std::max(1.0, factor) * 1.05) + " mm would fit");
  }
  const std::int64_t bone = voxmap.count_bone();
  DeviceState state;
  state.has_fill = needs_fill(voxmap, wear);
  state.bone = {device, voxels, "the voxmap"};
  state.fill = {device, state.has_fill ? voxels : 1, "the fill of the voxmap"};
  state.claims = {device, voxels / 32 + 1, "the claim bits"};
  state.codes = {device, std::max<std::size_t>(1, tool.shell.codes.size()), "the point shell"};
  state.contacts = {device, std::max<std::size_t>(1, contact_room(bone, tool.shell)), "the contact list"};
  state.removed = {device, std::max<std::size_t>(1, removed_room(bone, tool.shell)), "the list of removed voxels"};
  state.contact_count = {device, kMaxSlots, "the contact counts"};
  state.args = {device, kMaxSlots, "the substeps' arguments"};
  state.sums = {device, kMaxSlots, "the substeps' sums"};
  state.removed_count = {device, 1, "the count of removed voxels"};
  const auto edges = profile_edges(tool.profile);
  state.edges = {device, std::max<std::size_t>(1, edges.size()), "the tool's profile"};

  const std::vector<cl_uchar> grades = dense_grades_left(voxmap);
  state.bone.write(device, grades.data(), grades.size());
  if (state.has_fill) {
    const std::vector<cl_ushort> fill = dense_fill(voxmap);
    state.fill.write(device, fill.data(), fill.size());
  }
  if (!tool.shell.codes.empty()) state.codes.write(device, tool.shell.codes.data(), tool.shell.codes.size());
  if (!edges.empty()) state.edges.write(device, edges.data(), edges.size());
  state.claims.clear(device, state.claims.count());
  return state;
}

}  // namespace reamsim
