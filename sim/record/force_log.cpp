// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/force_log.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <string_view>

#include "sim/base/csv.h"
#include "sim/base/error.h"
#include "sim/record/row_decimator.h"

namespace reamsim {

namespace {

/// First columns of the quantities in kNames.
enum ForceColumn {
  kFrame,
  kTime,
  kPosition,
  kOrientation = kPosition + 3,
  kSpinAngle = kOrientation + 4,
  kDepth,
  kForce,
  kAxial = kForce + 3,
  kTorque,
  kRemoved,
  kEnergy,
  kFloorEnergy,
  kBalance,
  kColumns
};

constexpr std::array<std::string_view, kColumns> kNames{
    "frame",         "time_s",          "tool_x_mm",      "tool_y_mm", "tool_z_mm",       "tool_qw",   "tool_qx",
    "tool_qy",       "tool_qz",         "spin_angle_rad", "depth_mm",  "force_x_n",       "force_y_n", "force_z_n",
    "axial_force_n", "spin_torque_nmm", "removed_mm3",    "energy_mj", "floor_energy_mj", "balance"};

/// Logs of older versions have no passes; only a tool that a hand pushes has the others.
constexpr std::array<std::string_view, 7> kOptionalNames{"pass",         "feed_mm_s",    "velocity_mm_s", "thrust_n",
                                                         "hand_force_n", "hand_power_w", "drill_power_w"};
/// A tool farther away is a damaged file: recorded poses reach 1e6 mm along each axis of the motion's frame, which may
/// be rotated.
constexpr double kFarthest_mm = 2e6;

/// `v`: the values of a row, in the order of kNames and kOptionalNames.
ForceRow make_row(const SourceLocation& where, const std::vector<double>& v) {
  ForceRow row;
  row.frame = frame_number(v[kFrame], where);
  row.pass = std::isnan(v[kColumns]) ? 1 : pass_number(v[kColumns], where);
  row.time_s = v[kTime];
  row.pose.position_mm = Vec3(&v[kPosition]);
  if (!(row.pose.position_mm.cwiseAbs().maxCoeff() <= kFarthest_mm)) {
    throw InputError(where, "tool_x_mm", "the position of the tool is out of range",
                     fmt::format("expected at most {:g} mm", kFarthest_mm));
  }
  row.pose.orientation = Quat(v[kOrientation], v[kOrientation + 1], v[kOrientation + 2], v[kOrientation + 3]);
  if (std::abs(row.pose.orientation.norm() - 1) > 1e-3) {
    throw InputError(where, "tool_qw", "the quaternion does not have length 1", "expected a rotation");
  }
  row.pose.orientation.normalize();
  row.pose.spin_angle_rad = v[kSpinAngle];
  row.depth_mm = v[kDepth];
  row.force_n = Vec3(&v[kForce]);
  row.axial_force_n = v[kAxial];
  row.spin_torque_nmm = v[kTorque];
  row.removed_mm3 = v[kRemoved];
  row.cumulative_energy_mj = v[kEnergy];
  row.cumulative_floor_mj = v[kFloorEnergy];
  row.balance = v[kBalance];
  const double* const push = &v[kColumns + 1];
  if (std::all_of(push, push + 6, [](double value) { return std::isfinite(value); })) {
    row.push = PushResult{push[0], push[1], push[2], push[3], push[4], push[5]};
  }
  return row;
}

/// Sets the means of rows in ascending order.
class LayerMeans {
 public:
  explicit LayerMeans(double travel_mm) : travel_mm_(travel_mm), mean_(travel_mm) {}

  void set(ForceRow& row) {
    if (travel_mm_ == 0) {
      row.layer_axial_force_n = row.axial_force_n;
      row.layer_spin_torque_nmm = row.spin_torque_nmm;
      row.layer_force_n = row.force_n;
      row.layer_frames = 1;
    } else {
      const auto means = mean_.add(row.pose.position_mm, row.axial_force_n, row.spin_torque_nmm);
      row.layer_axial_force_n = means.axial_force_n;
      row.layer_spin_torque_nmm = means.spin_torque_nmm;
      row.layer_force_n = means.axial_force_n * (row.pose.orientation * Vec3::UnitZ());
      row.layer_frames = means.frames;
    }
    points_.push_back({row.time_s, row.depth_mm, row.removed_mm3, row.cumulative_energy_mj});
    if (points_.size() > kMaxPoints) points_.pop_front();
    row.layer_middle = point_before(row.layer_frames / 2);
    row.layer_begin = point_before(row.layer_frames);
  }

 private:
  /// A longer stretch of frames begins here: 4 MB.
  static constexpr std::size_t kMaxPoints = 131'072;

  [[nodiscard]] const RowPoint& point_before(std::size_t frames) const {
    return points_[points_.size() - 1 - std::min(frames, points_.size() - 1)];
  }

  double travel_mm_;
  LayerMean mean_;
  std::deque<RowPoint> points_;  ///< of the last rows
};

}  // namespace

const ForceRow& ForceLog::at(std::int64_t frame, const std::string& path) const {
  const auto after = std::upper_bound(rows.begin(), rows.end(), frame,
                                      [](std::int64_t wanted, const ForceRow& row) { return wanted < row.frame; });
  if (after == rows.begin()) return rows.front();
  const ForceRow& row = *std::prev(after);
  if (row.frame != frame) {
    throw InputError({path, 0, 0}, "frame", "no row for frame " + std::to_string(frame) + " of snapshots/",
                     "run the scenario again");
  }
  return row;
}

void for_each_force_row(const std::string& path, const std::function<void(const ForceRow&)>& visit) {
  CsvReader table(path, kNames, "the forces.csv of a run", kOptionalNames);
  double removed_mm3 = 0, energy_mj = 0, floor_mj = 0;
  std::int64_t before = -1;
  for (std::vector<double> values; table.next(values);) {
    ForceRow row = make_row(table.where(), values);
    if (row.frame <= before) {
      throw InputError(table.where(), "frame", "frames are not in ascending order", "the forces.csv of a run");
    }
    before = row.frame;
    row.removed_mm3 = removed_mm3 += row.removed_mm3;
    row.cumulative_energy_mj = energy_mj += row.cumulative_energy_mj;
    row.cumulative_floor_mj = floor_mj += row.cumulative_floor_mj;
    visit(row);
  }
  if (before < 0) throw InputError({path, 0, 0}, "", "has no rows", "run the scenario again");
}

ForceLog read_force_log(const std::string& path, const LogOptions& options) {
  LayerMeans means(options.mean_travel_mm);
  RowDecimator decimator(options.keep, options.most_rows);
  for_each_force_row(path, [&](const ForceRow& read) {
    ForceRow row = read;
    means.set(row);
    if (options.each) options.each(row);
    decimator.add(row);
  });
  return {decimator.finish(), options.mean_travel_mm, decimator.bucket_rows()};
}

void add_layer_means(ForceLog& log, double travel_mm) {
  // The frames between the rows of a decimated log are needed for means.
  if (log.is_decimated() && travel_mm != 0) return;
  LayerMeans means(travel_mm);
  for (ForceRow& row : log.rows) means.set(row);
  log.mean_travel_mm = travel_mm;
}

KeyResults key_results_of(const ForceLog& log, bool means) {
  KeyResults out{.means = means};
  for (const ForceRow& row : log.rows) {
    out.peak_axial_force_n = std::max(out.peak_axial_force_n, row.layer_axial_force_n);
    out.peak_spin_torque_nmm = std::max(out.peak_spin_torque_nmm, std::abs(row.layer_spin_torque_nmm));
    out.tool_depth_mm = std::max(out.tool_depth_mm, row.depth_mm);
  }
  return out;
}

namespace {

constexpr std::size_t kPlannedColumns = 26, kDeflectedColumns = kPlannedColumns + 3;
constexpr std::size_t kFrameColumn = 0, kContactsColumn = 20, kPassColumn = 25;
/// Counts up to here are whole numbers of a double.
constexpr double kLargestCount = 1e15, kLargestPass = 1e4;

std::int64_t count_in(double value, double least, double most, const char* column, const SourceLocation& where) {
  if (value >= least && value <= most) return static_cast<std::int64_t>(value);
  throw InputError(where, column, "out of range", "expected a forces.csv as reamsim wrote it");
}

}  // namespace

std::int64_t frame_number(double value, const SourceLocation& where) {
  return count_in(value, 0, kLargestCount, "frame", where);
}

int pass_number(double value, const SourceLocation& where) {
  return static_cast<int>(count_in(value, 1, kLargestPass, "pass", where));
}

std::string force_columns(PoseFeedback feedback) {
  return std::string(kForceColumns) + (feedback.push ? kPushColumns : "") +
         (feedback.springs ? kDeflectionColumns : "");
}

std::vector<double> force_row(const FrameResult& r) {
  const Vec3 &p = r.pose.position_mm, &f = r.force_n, &t = r.torque_nmm;
  const Quat& q = r.pose.orientation;
  std::vector<double> out{static_cast<double>(r.frame),
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
                          static_cast<double>(r.pass)};
  if (const auto& push = r.push) {
    out.insert(out.end(), {push->feed_mm_s, push->velocity_mm_s, push->thrust_n, push->hand_force_n, push->hand_power_w,
                           push->drill_power_w});
  }
  if (r.deflection_mm) out.insert(out.end(), r.deflection_mm->begin(), r.deflection_mm->end());
  return out;
}

FrameResult result_of(std::span<const double> v, const SourceLocation& where) {
  FrameResult out;
  out.frame = frame_number(v[kFrameColumn], where);
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
  out.contacts = count_in(v[kContactsColumn], 0, kLargestCount, "contacts", where);
  out.removed_mm3 = v[21];
  out.energy_mj = v[22];
  out.floor_energy_mj = v[23];
  out.balance = v[24];
  out.pass = pass_number(v[kPassColumn], where);
  if (v.size() == kDeflectedColumns) {
    out.deflection_mm = Vec3(&v[kPlannedColumns]);
  } else if (v.size() > kPlannedColumns) {
    out.push = PushResult{v[26], v[27], v[28], v[29], v[30], v[31]};
  }
  return out;
}

}  // namespace reamsim
