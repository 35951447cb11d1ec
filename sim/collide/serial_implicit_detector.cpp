#include "sim/collide/serial_implicit_detector.h"

#include "kernels/cut_law.h"

namespace reamsim {

void SerialImplicitDetector::detect(int slot) {
  const Stopwatch watch;
  const SubstepArgs& args = state_.args[static_cast<std::size_t>(slot)];
  const ProfileView profile = state_.profile.view();
  for (std::int64_t e = 0; e < state_.grid.size(); ++e) {
    if (state_.bone[static_cast<std::size_t>(e)] == 0) continue;
    const Vec3i voxel = state_.grid.coord(e);
    if (rs_holds_voxel(&args, &profile, voxel.x(), voxel.y(), voxel.z())) {
      state_.contacts.push_back(e);
    }
  }
  seconds_.push_back(watch.seconds());
}

}  // namespace reamsim
