#include "sim/collide/serial_detector.h"

#include "kernels/cut_law.h"
#include "sim/tool/morton.h"

namespace reamsim {

void SerialDetector::detect(int slot) {
  const Stopwatch watch;
  const SubstepArgs& args = state_.args[static_cast<std::size_t>(slot)];
  const ProfileView profile = state_.profile.view();
  LaneSums point_sums{};
  for (const std::uint64_t code : state_.tool->shell.codes) {
    const Vec3i cell = morton_decode(code);
    const int x = cell.x(), y = cell.y(), z = cell.z();
    const Vec3i voxel(rs_voxel_coordinate(&args, 0, x, y, z), rs_voxel_coordinate(&args, 1, x, y, z),
                      rs_voxel_coordinate(&args, 2, x, y, z));
    if (!state_.grid.contains(voxel)) continue;
    const auto e = static_cast<std::size_t>(state_.grid.index(voxel.x(), voxel.y(), voxel.z()));
    if (state_.bone[e] == 0) continue;
    if (args.law == RS_LAW_PER_POINT) {
      rs_point_force(&args, &profile, x, y, z, &point_sums);
    }
    if (claimed_[e]) continue;
    claimed_[e] = true;
    state_.contacts.push_back(static_cast<std::int64_t>(e));
  }
  rs_add_lanes(&state_.sums[static_cast<std::size_t>(slot)], &point_sums);
  for (const std::int64_t e : state_.contacts) claimed_[static_cast<std::size_t>(e)] = false;
  seconds_.push_back(watch.seconds());
}

}  // namespace reamsim
