#include "sim/collide/device_state.h"

#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/tool/morton.h"

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

bool needs_wide_codes(const PointShell& shell) {
  return shell.resolution > kNarrowResolution;
}

std::size_t code_bytes(const PointShell& shell) {
  return (needs_wide_codes(shell) ? sizeof(cl_ulong) : sizeof(cl_uint)) * shell.codes.size();
}

void upload_shell(const cl::Device& device, const PointShell& shell, DeviceState& state) {
  state.points = shell.codes.size();
  state.wide_codes = needs_wide_codes(shell);
  state.codes = {device, code_bytes(shell), "the point shell"};
  const auto write = [&](const auto& codes) {
    state.codes.write(device, reinterpret_cast<const cl_uchar*>(codes.data()), code_bytes(shell));
  };
  if (state.wide_codes) return write(shell.codes);
  std::vector<cl_uint> narrow(shell.codes.size());
  std::transform(shell.codes.begin(), shell.codes.end(), narrow.begin(),
                 [](std::uint64_t code) { return static_cast<cl_uint>(code); });
  write(narrow);
}

/// The device's view of the bone: 0 where nothing is left.
std::vector<cl_uchar> grades_left(const Voxmap& voxmap) {
  std::vector<cl_uchar> out(voxmap.grade.begin(), voxmap.grade.end());
  if (voxmap.fill.stored_bricks() == 0) return out;
  for (std::int64_t e = 0; e < voxmap.grid.size(); ++e) {
    if (out[static_cast<std::size_t>(e)] != 0 && voxmap.fill.get(voxmap.grid.coord(e)) == 0) {
      out[static_cast<std::size_t>(e)] = 0;
    }
  }
  return out;
}

std::vector<cl_ushort> dense_fill(const Voxmap& voxmap) {
  std::vector<cl_ushort> out(voxmap.grade.size());
  for (std::int64_t e = 0; e < voxmap.grid.size(); ++e) {
    out[static_cast<std::size_t>(e)] = voxmap.fill.get(voxmap.grid.coord(e));
  }
  return out;
}

}  // namespace

std::size_t device_bytes(const Voxmap& voxmap, const PointShell& shell, bool wear) {
  const auto voxels = static_cast<std::size_t>(voxmap.grid.size());
  const std::int64_t bone = voxmap.count_bone();
  return voxels + (needs_fill(voxmap, wear) ? 2 * voxels : 0) + voxels / 8 + code_bytes(shell) +
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
  state.contacts = {device, std::max<std::size_t>(1, contact_room(bone, tool.shell)), "the contact list"};
  state.removed = {device, std::max<std::size_t>(1, removed_room(bone, tool.shell)), "the list of removed voxels"};
  state.contact_count = {device, kMaxSlots, "the contact counts"};
  state.args = {device, kMaxSlots, "the substeps' arguments"};
  state.sums = {device, kMaxSlots, "the substeps' sums"};
  state.removed_count = {device, 1, "the count of removed voxels"};
  const auto edges = profile_edges(tool.profile);
  state.edges = {device, std::max<std::size_t>(1, edges.size()), "the tool's profile"};

  const auto grades = grades_left(voxmap);
  state.bone.write(device, grades.data(), grades.size());
  if (state.has_fill) {
    const auto fill = dense_fill(voxmap);
    state.fill.write(device, fill.data(), fill.size());
  }
  upload_shell(device, tool.shell, state);
  if (!edges.empty()) state.edges.write(device, edges.data(), edges.size());
  state.claims.clear(device, state.claims.count());
  return state;
}

}  // namespace reamsim
