#include "sim/cut/serial_clip.h"

#include "kernels/clip.h"

namespace reamsim {

void SerialClip::cut(int slot) {
  const Stopwatch watch;
  const SubstepArgs& args = state_.args[static_cast<std::size_t>(slot)];
  SubstepSums& sums = state_.sums[static_cast<std::size_t>(slot)];
  const OutlineView outline = state_.outline.view();
  LaneSums law{};
  for (const std::int64_t e : state_.contacts) {
    const auto i = static_cast<std::size_t>(e);
    const Vec3i voxel = state_.grid.coord(e);
    float corner[3];
    rs_brick_in_tool(&args, voxel.x(), voxel.y(), voxel.z(), corner);
    const Clip clip = rs_clip(&args, &outline, outline.lists[0], corner, static_cast<float>(voxel.x() & 7),
                              static_cast<float>(voxel.y() & 7), static_cast<float>(voxel.z() & 7));
    const rs_i32 outside = rs_fill_outside(&clip), lost = rs_clip_loss(&args, state_.fill[i], outside);
    if (rs_has_edge(&args)) rs_edge_force(&args, &clip, state_.fill[i] - lost, outside, &law);
    if (lost == 0) continue;
    sums.contacts += 1;
    sums.removed += lost;
    rs_clip_force(&args, &clip, static_cast<float>(table_.energy_mj[state_.bone[i]]), lost, &law);
    state_.fill[i] = static_cast<std::uint16_t>(state_.fill[i] - lost);
    if (state_.fill[i] == 0) {
      state_.bone[i] = 0;
      state_.removed.emplace_back(e, args.frame);
    }
  }
  rs_add_lanes(&sums, &law);
  state_.contacts.clear();
  seconds_.push_back(watch.seconds());
}

}  // namespace reamsim
