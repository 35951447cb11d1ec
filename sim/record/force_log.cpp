// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/force_log.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <string_view>
#include <type_traits>
#include <utility>

#include "sim/base/csv.h"
#include "sim/base/error.h"

namespace reamsim {

namespace {

constexpr std::array<std::string_view, 20> kNames{
    "frame",         "time_s",          "tool_x_mm",      "tool_y_mm", "tool_z_mm",       "tool_qw",   "tool_qx",
    "tool_qy",       "tool_qz",         "spin_angle_rad", "depth_mm",  "force_x_n",       "force_y_n", "force_z_n",
    "axial_force_n", "spin_torque_nmm", "removed_mm3",    "energy_mj", "floor_energy_mj", "balance"};
/// Logs of older versions have no passes; only a tool that a hand pushes has the others.
constexpr std::array<std::string_view, 7> kOptionalNames{"pass",         "feed_mm_s",    "velocity_mm_s", "thrust_n",
                                                         "hand_force_n", "hand_power_w", "drill_power_w"};
/// A tool farther away is a damaged file: recorded poses reach 1e6 mm along each axis of the motion's frame, which may
/// be rotated.
constexpr double kFarthest_mm = 2e6;

/// Counts up to here are whole numbers of a double.
constexpr double kLargestCount = 1e15, kLargestPass = 1e4;

std::int64_t count_in(double value, double least, double most, const char* column, const SourceLocation& where) {
  if (value >= least && value <= most) return static_cast<std::int64_t>(value);
  throw InputError(where, column, "out of range", "expected a forces.csv as reamsim wrote it");
}

/// The number of a frame or pass. Throw InputError for one that no run writes.
std::int64_t frame_number(double value, const SourceLocation& where) {
  return count_in(value, 0, kLargestCount, "frame", where);
}

int pass_number(double value, const SourceLocation& where) {
  return static_cast<int>(count_in(value, 1, kLargestPass, "pass", where));
}

ToolPose checked_pose(const double* position, const double* quaternion, const SourceLocation& where) {
  ToolPose pose;
  pose.position_mm = Vec3(position);
  if (!(pose.position_mm.cwiseAbs().maxCoeff() <= kFarthest_mm)) {
    throw InputError(where, "tool_x_mm", "the position of the tool is out of range",
                     fmt::format("expected at most {:g} mm", kFarthest_mm));
  }
  pose.orientation = Quat(quaternion[0], quaternion[1], quaternion[2], quaternion[3]);
  if (std::abs(pose.orientation.norm() - 1) > 1e-3) {
    throw InputError(where, "tool_qw", "the quaternion does not have length 1", "expected a rotation");
  }
  pose.orientation.normalize();
  return pose;
}

/// `values`: of a row, in the order of kNames and kOptionalNames.
ForceRow make_row(const SourceLocation& where, const std::vector<double>& values) {
  ForceRow row;
  const double* v = values.data();
  row.frame = frame_number(*v++, where);
  row.time_s = *v++;
  row.pose = checked_pose(v, v + 3, where);
  v += 7;
  for (double* value : {&row.pose.spin_angle_rad, &row.depth_mm}) *value = *v++;
  row.force_n = Vec3(v);
  v += 3;
  for (double* value : {&row.axial_force_n, &row.spin_torque_nmm, &row.removed_mm3, &row.cumulative_energy_mj,
                        &row.cumulative_floor_mj, &row.balance}) {
    *value = *v++;
  }
  row.pass = std::isnan(*v) ? 1 : pass_number(*v, where);
  ++v;
  if (std::all_of(v, v + 6, [](double value) { return std::isfinite(value); })) {
    row.push = PushResult{v[0], v[1], v[2], v[3], v[4], v[5]};
  }
  return row;
}

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

/// About two buckets per pixel of a printed figure when there are most of them.
constexpr std::size_t kMaxBuckets = 4096;
/// Rows that wait in a bucket before it is reduced.
constexpr std::size_t kWaiting = 256;

constexpr double (*kQuantities[])(const ForceRow&) = {
    [](const ForceRow& row) { return row.axial_force_n; },
    [](const ForceRow& row) { return row.spin_torque_nmm; },
    [](const ForceRow& row) { return row.depth_mm; },
    [](const ForceRow& row) { return row.layer_axial_force_n; },
    [](const ForceRow& row) { return row.layer_spin_torque_nmm; },
    [](const ForceRow& row) { return row.layer_force_n.norm(); },
    [](const ForceRow& row) { return std::abs(row.balance); },
    [](const ForceRow& row) { return row.push ? row.push->feed_mm_s : 0; },
    [](const ForceRow& row) { return row.push ? row.push->drill_power_w : 0; },
};

}  // namespace

void RowDecimator::add(const ForceRow& row) {
  last_ = row;
  if (bucket_rows_ > 1) {
    add_to_bucket(row);
    return;
  }
  rows_.push_back(row);
  if (rows_.size() > most_rows_) start_buckets();
}

std::vector<ForceRow> RowDecimator::finish() {
  for (Bucket& bucket : buckets_) {
    reduce(bucket);
    rows_.insert(rows_.end(), bucket.begin(), bucket.end());
    bucket = {};
  }
  if (!rows_.empty() && rows_.back().frame != last_.frame) rows_.push_back(last_);
  return std::move(rows_);
}

void RowDecimator::start_buckets() {
  const Bucket all = std::exchange(rows_, {});
  bucket_rows_ = 2;
  while (all.size() > kMaxBuckets / 2 * static_cast<std::size_t>(bucket_rows_)) bucket_rows_ *= 2;
  for (const ForceRow& row : all) add_to_bucket(row);
}

void RowDecimator::add_to_bucket(const ForceRow& row) {
  if (buckets_.empty() || in_last_ == bucket_rows_) {
    if (!buckets_.empty()) reduce(buckets_.back());
    if (buckets_.size() == kMaxBuckets) merge_pairs();
    buckets_.emplace_back();
    in_last_ = 0;
  }
  Bucket& bucket = buckets_.back();
  bucket.push_back(row);
  ++in_last_;
  if (bucket.size() > kWaiting + keep_.size()) reduce(bucket);
}

void RowDecimator::merge_pairs() {
  for (std::size_t i = 0; i < kMaxBuckets; i += 2) {
    Bucket pair = std::move(buckets_[i]);
    pair.insert(pair.end(), buckets_[i + 1].begin(), buckets_[i + 1].end());
    reduce(pair);
    buckets_[i / 2] = std::move(pair);
  }
  buckets_.resize(kMaxBuckets / 2);
  bucket_rows_ *= 2;
}

void RowDecimator::reduce(Bucket& bucket) const {
  std::vector<bool> chosen(bucket.size(), false);
  chosen[0] = true;
  for (const auto quantity : kQuantities) {
    const auto [least, most] = std::ranges::minmax_element(bucket, {}, quantity);
    chosen[static_cast<std::size_t>(least - bucket.begin())] = true;
    chosen[static_cast<std::size_t>(most - bucket.begin())] = true;
  }
  Bucket out;
  for (std::size_t i = 0; i < bucket.size(); ++i) {
    if (chosen[i] || std::ranges::binary_search(keep_, bucket[i].frame)) out.push_back(bucket[i]);
  }
  bucket = std::move(out);
}

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

/// Calls visit() for the values of a row, in the order of kForceColumns.
template <class Result, class Visit>
void visit_values(Result& r, const Visit& visit) {
  visit(r.frame);
  visit(r.time_s);
  for (auto& coordinate : r.pose.position_mm) visit(coordinate);
  auto& q = r.pose.orientation;
  visit(q.w());
  for (auto& part : q.vec()) visit(part);
  visit(r.pose.spin_rpm);
  visit(r.pose.spin_angle_rad);
  visit(r.depth_mm);
  for (auto& component : r.force_n) visit(component);
  for (auto& component : r.torque_nmm) visit(component);
  visit(r.axial_force_n);
  visit(r.spin_torque_nmm);
  visit(r.contacts);
  visit(r.removed_mm3);
  visit(r.energy_mj);
  visit(r.floor_energy_mj);
  visit(r.balance);
  visit(r.pass);
}

}  // namespace

std::string force_columns(PoseFeedback feedback) {
  return std::string(kForceColumns) + (feedback.push ? kPushColumns : "") +
         (feedback.springs ? kDeflectionColumns : "");
}

std::vector<double> force_row(const FrameResult& r) {
  std::vector<double> out;
  visit_values(r, [&](auto value) { out.push_back(static_cast<double>(value)); });
  if (const auto& push = r.push) {
    out.insert(out.end(), {push->feed_mm_s, push->velocity_mm_s, push->thrust_n, push->hand_force_n, push->hand_power_w,
                           push->drill_power_w});
  }
  if (r.deflection_mm) out.insert(out.end(), r.deflection_mm->begin(), r.deflection_mm->end());
  return out;
}

FrameResult result_of(std::span<const double> row, const SourceLocation& where) {
  FrameResult out;
  const double* v = row.data();
  visit_values(out, [&](auto& value) {
    using Value = std::remove_reference_t<decltype(value)>;
    if constexpr (std::is_same_v<Value, double>) {
      value = *v++;
    } else if constexpr (std::is_same_v<Value, int>) {
      value = pass_number(*v++, where);
    } else {
      value = count_in(*v++, 0, kLargestCount, &value == &out.frame ? "frame" : "contacts", where);
    }
  });
  if (const auto more = row.data() + row.size() - v; more == 3) {
    out.deflection_mm = Vec3(v);
  } else if (more > 0) {
    out.push = PushResult{v[0], v[1], v[2], v[3], v[4], v[5]};
  }
  return out;
}

}  // namespace reamsim
