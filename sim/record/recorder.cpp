#include "sim/record/recorder.h"

#include <utility>

#include "sim/base/file.h"
#include "sim/record/snapshot.h"

namespace reamsim {

namespace {

constexpr const char* kForceColumns =
    "frame,time_s,tool_x_mm,tool_y_mm,tool_z_mm,tool_qw,tool_qx,tool_qy,tool_qz,spin_rpm,spin_angle_rad,depth_mm,"
    "force_x_n,force_y_n,force_z_n,torque_x_nmm,torque_y_nmm,torque_z_nmm,axial_force_n,spin_torque_nmm,contacts,"
    "removed_mm3,energy_mj,floor_energy_mj,balance,pass";
constexpr const char* kTimingColumns = "frame,broad_phase_ms,detect_ms,cut_ms";

/// `v`: a row of forces.csv, as Recorder::frame() writes it.
FrameResult result_of(const std::vector<double>& v) {
  FrameResult out;
  out.frame = static_cast<std::int64_t>(v[0]);
  out.time_s = v[1];
  out.pose = {.position_mm = Vec3(&v[2]),
              .orientation = Quat(v[5], v[6], v[7], v[8]),
              .spin_angle_rad = v[10],
              .spin_rpm = v[9]};
  out.depth_mm = v[11];
  out.force_n = Vec3(&v[12]);
  out.torque_nmm = Vec3(&v[15]);
  out.axial_force_n = v[18];
  out.spin_torque_nmm = v[19];
  out.contacts = static_cast<std::int64_t>(v[20]);
  out.removed_mm3 = v[21];
  out.energy_mj = v[22];
  out.floor_energy_mj = v[23];
  out.balance = v[24];
  out.pass = static_cast<int>(v[25]);
  return out;
}

}  // namespace

Recorder::Recorder(const std::string& dir, double voxel_mm, bool force_basis)
    : dir_(dir),
      forces_(dir + "/forces.csv", kForceColumns),
      timings_(dir + "/timings.csv", kTimingColumns),
      totals_(voxel_mm) {
  if (force_basis) basis_.emplace(dir + "/" + kForceBasisName);
}

Recorder::Recorder(const std::string& dir, double voxel_mm, std::int64_t frame, const LogLengths& logs,
                   RemovedFrames removed)
    : dir_(dir),
      forces_(dir + "/forces.csv", kForceColumns, logs.forces_bytes),
      timings_(dir + "/timings.csv", kTimingColumns, logs.timings_bytes),
      totals_(voxel_mm),
      removed_(std::move(removed)) {
  if (logs.basis_bytes > 0) basis_.emplace(dir + "/" + kForceBasisName, logs.basis_bytes);
  remove_snapshots_after(dir, frame);
  add_rows_again();
}

void Recorder::add_rows_again() {
  const std::vector<std::string_view> forces = csv_cells(kForceColumns), timings = csv_cells(kTimingColumns);
  std::vector<double> row;
  for (CsvReader log(dir_ + "/forces.csv", forces, "the log of a run"); log.next(row);) totals_.add(result_of(row));
  for (CsvReader log(dir_ + "/timings.csv", timings, "the log of a run"); log.next(row);) {
    totals_.broad_phase_s += row[1] / 1e3;
    totals_.detect_s += row[2] / 1e3;
    totals_.cut_s += row[3] / 1e3;
  }
}

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
               r.balance,
               static_cast<double>(r.pass)});
  timings_.row({frame, 1e3 * times.broad_phase_s, 1e3 * times.detect_s, 1e3 * times.cut_s});
  totals_.add(r);
  totals_.broad_phase_s += times.broad_phase_s;
  totals_.detect_s += times.detect_s;
  totals_.cut_s += times.cut_s;
}

void Recorder::basis(const std::vector<BasisRow>& rows) {
  if (basis_) basis_->rows(rows);
}

void Recorder::snapshot(std::int64_t frame, FillBricks& fill) {
  write_snapshot(dir_, frame, fill);
  unsynced_.push_back(snapshot_path(dir_, frame));
}

void Recorder::removed(const RemovedFrames& voxels) {
  removed_.insert(removed_.end(), voxels.begin(), voxels.end());
}

LogLengths Recorder::sync() {
  for (const std::string& snapshot : std::exchange(unsynced_, {})) sync_to_disk(snapshot);
  sync_to_disk(dir_ + "/snapshots");
  return {.forces_bytes = forces_.sync(), .timings_bytes = timings_.sync(), .basis_bytes = basis_ ? basis_->sync() : 0};
}

void Recorder::close() {
  forces_.close();
  timings_.close();
  if (basis_) basis_->close();
}

}  // namespace reamsim
