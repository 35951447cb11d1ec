#include "sim/cut/serial_erosion.h"

#include "kernels/cut_law.h"

namespace reamsim {

void SerialErosion::cut(int slot) {
  const Stopwatch watch;
  const SubstepArgs& args = state_.args[static_cast<std::size_t>(slot)];
  SubstepSums& sums = state_.sums[static_cast<std::size_t>(slot)];
  const ProfileView profile = state_.profile.view();
  LaneSums law{};
  for (const std::int64_t e : state_.contacts) {
    const auto i = static_cast<std::size_t>(e);
    const std::uint8_t grade = state_.bone[i];
    const rs_i32 before = state_.fill[i];
    const rs_i32 lost = rs_lost_fill(&args, table_.density_g_cm3[grade], before);
    const double energy = rs_lost_energy(table_.energy_mj[grade], lost);
    sums.contacts += 1;
    sums.removed += lost;
    sums.energy += rs_energy_units(energy);
    if (args.law == RS_LAW_ENERGY) {
      const Vec3i voxel = state_.grid.coord(e);
      rs_voxel_force(&args, &profile, voxel.x(), voxel.y(), voxel.z(), static_cast<float>(energy), &law);
    }
    state_.fill[i] = static_cast<std::uint16_t>(before - lost);
    if (lost == before) {
      state_.bone[i] = 0;
      state_.removed.emplace_back(e, args.frame);
    }
  }
  rs_add_lanes(&sums, &law);
  state_.contacts.clear();
  seconds_.push_back(watch.seconds());
}

}  // namespace reamsim
