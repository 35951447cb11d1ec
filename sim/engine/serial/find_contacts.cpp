#include "sim/engine/serial/find_contacts.h"

#include "kernels/cut_law.h"
#include "sim/engine/common/voxel_box.h"
#include "sim/tool/morton.h"

namespace reamsim {

namespace {

/// `claimed`: by voxel, all false before and after.
void find_claiming(SerialState& state, const SubstepArgs& args, std::vector<bool>& claimed, SubstepSums& sums) {
  const ProfileView profile = view_of(state.profile);
  LaneSums point_sums{};
  for (const std::uint64_t code : state.tool->shell.codes) {
    const Vec3i cell = morton_decode(code);
    const int x = cell.x(), y = cell.y(), z = cell.z();
    const Vec3i voxel(rs_voxel_coordinate(&args, 0, x, y, z), rs_voxel_coordinate(&args, 1, x, y, z),
                      rs_voxel_coordinate(&args, 2, x, y, z));
    if (!state.grid.contains(voxel)) continue;
    const auto e = static_cast<std::size_t>(state.grid.index(voxel));
    if (state.bone[e] == 0) continue;
    if (args.law == RS_LAW_PER_POINT) {
      rs_point_force(&args, &profile, x, y, z, &point_sums);
    }
    if (claimed[e]) continue;
    claimed[e] = true;
    state.contacts.push_back(static_cast<std::int64_t>(e));
  }
  rs_add_lanes(&sums, &point_sums);
  for (const std::int64_t e : state.contacts) claimed[static_cast<std::size_t>(e)] = false;
}

}  // namespace

FindContacts find_by_points(const SerialState& made_for) {
  return [claimed = std::vector<bool>(made_for.bone.size(), false)](SerialState& state, const SubstepArgs& args,
                                                                    SubstepSums& sums) mutable {
    find_claiming(state, args, claimed, sums);
  };
}

void find_by_profile(SerialState& state, const SubstepArgs& args, SubstepSums& /*sums*/) {
  const ProfileView profile = view_of(state.profile);
  for (std::int64_t e = 0; e < state.grid.size(); ++e) {
    if (state.bone[static_cast<std::size_t>(e)] == 0) continue;
    const Vec3i voxel = state.grid.coord(e);
    if (rs_holds_voxel(&args, &profile, voxel.x(), voxel.y(), voxel.z())) state.contacts.push_back(e);
  }
}

void find_in_tool_box(SerialState& state, const SubstepArgs& args, SubstepSums& /*sums*/) {
  const VoxelGrid& grid = state.grid;
  // A voxel is met by a surface that passes less than its diagonal from its centre.
  const Aabb tool = state.tool->clip_bounds().expanded(grid.voxel_mm + state.outline.bulge_mm);
  const VoxelBox all{Vec3i::Zero(), grid.dims - Vec3i::Ones()};
  const VoxelBox box = voxel_voi(args, tool, all);
  for (int z = box.first.z(); z <= box.last.z(); ++z) {
    for (int y = box.first.y(); y <= box.last.y(); ++y) {
      for (int x = box.first.x(); x <= box.last.x(); ++x) {
        const std::int64_t e = grid.index({x, y, z});
        if (state.bone[static_cast<std::size_t>(e)] != 0) state.contacts.push_back(e);
      }
    }
  }
}

}  // namespace reamsim
