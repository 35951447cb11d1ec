#include "sim/engine/serial/cut_contacts.h"

#include "kernels/distance_grid.h"

namespace reamsim {

namespace {

/// The tool next to a voxel: by its teeth where these are resolved, else by its envelope.
Clip clip_of(const SerialState& state, const SubstepArgs& args, const OutlineView& outline, const Vec3i& voxel) {
  float corner[3];
  rs_brick_in_tool(&args, voxel.x(), voxel.y(), voxel.z(), corner);
  const auto x = static_cast<float>(voxel.x() & 7), y = static_cast<float>(voxel.y() & 7),
             z = static_cast<float>(voxel.z() & 7);
  if (!state.tool->teeth) return rs_clip(&args, &outline, outline.lists[0], corner, x, y, z);
  const DistanceGrid& grid = *state.tool->teeth;
  const DistanceView teeth{&state.lattice, grid.slot_of_brick.data(), grid.samples.data()};
  return rs_clip_grid(&args, &teeth, corner, x, y, z);
}

}  // namespace

CutVoxel cut_touched(const EnergyTable& table) {
  return [table](const SerialState& state, const SubstepArgs& args, std::int64_t e, LaneSums& law) {
    const auto i = static_cast<std::size_t>(e);
    const std::uint8_t grade = state.bone[i];
    const rs_i32 lost = rs_lost_fill(&args, table.density_g_cm3[grade], state.fill[i]);
    const double energy = rs_lost_energy(table.energy_mj[grade], lost);
    law.energy += rs_energy_units(energy);
    if (args.law == RS_LAW_ENERGY) {
      const Vec3i voxel = state.grid.coord(e);
      const ProfileView profile = view_of(state.profile);
      rs_voxel_force(&args, &profile, voxel.x(), voxel.y(), voxel.z(), static_cast<float>(energy), &law);
    }
    return lost;
  };
}

CutVoxel cut_by_clipping(const EnergyTable& table) {
  return [table](const SerialState& state, const SubstepArgs& args, std::int64_t e, LaneSums& law) {
    const auto i = static_cast<std::size_t>(e);
    const Vec3i voxel = state.grid.coord(e);
    const OutlineView outline = view_of(state.outline);
    Clip clip = clip_of(state, args, outline, voxel);
    const rs_i32 outside = rs_fill_outside(&clip), lost = rs_clip_loss(&args, state.fill[i], outside);
    if (rs_has_edge(&args)) rs_edge_force(&args, &clip, state.fill[i] - lost, outside, &law);
    if (lost == 0) return lost;
    if (state.tool->teeth) rs_face_envelope(&outline, outline.lists[0], &clip);
    rs_clip_force(&args, &clip, static_cast<float>(table.energy_mj[state.bone[i]]), lost, &law);
    return lost;
  };
}

void cut_contacts(SerialState& state, const SubstepArgs& args, const CutVoxel& cut, SubstepSums& sums) {
  LaneSums law{};
  for (const std::int64_t e : state.contacts) {
    const auto i = static_cast<std::size_t>(e);
    const rs_i32 lost = cut(state, args, e, law);
    if (lost == 0) continue;
    sums.contacts += 1;
    sums.removed += lost;
    state.fill[i] = static_cast<std::uint16_t>(state.fill[i] - lost);
    if (state.fill[i] == 0) {
      state.bone[i] = 0;
      state.removed.emplace_back(e, args.frame);
    }
  }
  rs_add_lanes(&sums, &law);
  state.contacts.clear();
}

}  // namespace reamsim
