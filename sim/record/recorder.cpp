#include "sim/record/recorder.h"

#include "sim/record/snapshot.h"

namespace reamsim {

namespace {

constexpr const char* kForceColumns =
    "frame,time_s,tool_x_mm,tool_y_mm,tool_z_mm,tool_qw,tool_qx,tool_qy,tool_qz,spin_rpm,spin_angle_rad,depth_mm,"
    "force_x_n,force_y_n,force_z_n,torque_x_nmm,torque_y_nmm,torque_z_nmm,axial_force_n,spin_torque_nmm,contacts,"
    "removed_mm3,energy_mj,floor_energy_mj,balance";
constexpr const char* kTimingColumns = "frame,broad_phase_ms,detect_ms,cut_ms";

}  // namespace

Recorder::Recorder(const std::string& dir, double voxel_mm)
    : dir_(dir),
      forces_(dir + "/forces.csv", kForceColumns),
      timings_(dir + "/timings.csv", kTimingColumns),
      totals_(voxel_mm) {}

void Recorder::frame(const FrameResult& r, const FrameTimes& times) {
  const auto frame = static_cast<double>(r.frame);
  const Vec3 &p = r.pose.position_mm, &f = r.force_n, &t = r.torque_nmm;
  const Quat& q = r.pose.orientation;
  forces_.row({frame,
               r.time_s,
               p.x(),
               p.y(),
               p.z(),
               q.w(),
               q.x(),
               q.y(),
               q.z(),
               r.pose.spin_rpm,
               r.pose.spin_angle_rad,
               r.depth_mm,
               f.x(),
               f.y(),
               f.z(),
               t.x(),
               t.y(),
               t.z(),
               r.axial_force_n,
               r.spin_torque_nmm,
               static_cast<double>(r.contacts),
               r.removed_mm3,
               r.energy_mj,
               r.floor_energy_mj,
               r.balance});
  timings_.row({frame, 1e3 * times.broad_phase_s, 1e3 * times.detect_s, 1e3 * times.cut_s});
  totals_.add(r);
  totals_.broad_phase_s += times.broad_phase_s;
  totals_.detect_s += times.detect_s;
  totals_.cut_s += times.cut_s;
}

void Recorder::snapshot(std::int64_t frame, FillBricks& fill) {
  write_snapshot(dir_, frame, fill);
}

void Recorder::removed(const RemovedFrames& voxels) {
  removed_.insert(removed_.end(), voxels.begin(), voxels.end());
}

void Recorder::close() {
  forces_.close();
  timings_.close();
}

}  // namespace reamsim
