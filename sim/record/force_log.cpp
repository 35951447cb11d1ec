// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/force_log.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <span>
#include <string_view>
#include <type_traits>

#include "sim/base/csv.h"
#include "sim/base/error.h"

namespace reamsim {

namespace {

/// A tool farther away is a damaged file: recorded poses reach 1e6 mm along each axis of the motion's frame, which may
/// be rotated.
constexpr double kFarthest_mm = 2e6;

/// The columns of forces.csv: calls visit(name, value) for each that a run with the parts of `r` writes, in their
/// order.
template <class Result, class Visit>
void visit_columns(Result& r, const Visit& visit) {
  const auto visit_vector = [&](auto& v, const char* x, const char* y, const char* z) {
    visit(x, v.x());
    visit(y, v.y());
    visit(z, v.z());
  };
  visit("frame", r.frame);
  visit("time_s", r.time_s);
  visit_vector(r.pose.position_mm, "tool_x_mm", "tool_y_mm", "tool_z_mm");
  visit("tool_qw", r.pose.orientation.w());
  visit_vector(r.pose.orientation, "tool_qx", "tool_qy", "tool_qz");
  visit("spin_rpm", r.pose.spin_rpm);
  visit("spin_angle_rad", r.pose.spin_angle_rad);
  visit("depth_mm", r.depth_mm);
  visit_vector(r.force_n, "force_x_n", "force_y_n", "force_z_n");
  visit_vector(r.torque_nmm, "torque_x_nmm", "torque_y_nmm", "torque_z_nmm");
  visit("axial_force_n", r.axial_force_n);
  visit("spin_torque_nmm", r.spin_torque_nmm);
  visit("contacts", r.contacts);
  visit("removed_mm3", r.removed_mm3);
  visit("energy_mj", r.energy_mj);
  visit("floor_energy_mj", r.floor_energy_mj);
  visit("balance", r.balance);
  visit("pass", r.pass);
  if (r.push) {
    visit("feed_mm_s", r.push->feed_mm_s);
    visit("velocity_mm_s", r.push->velocity_mm_s);
    visit("thrust_n", r.push->thrust_n);
    visit("hand_force_n", r.push->hand_force_n);
    visit("hand_power_w", r.push->hand_power_w);
    visit("drill_power_w", r.push->drill_power_w);
  }
  if (r.deflection_mm) visit_vector(*r.deflection_mm, "deflection_x_mm", "deflection_y_mm", "deflection_z_mm");
}

/// A result with the parts that a run has.
FrameResult result_with(PoseFeedback feedback) {
  FrameResult out;
  if (feedback.push) out.push.emplace();
  if (feedback.springs) out.deflection_mm.emplace(Vec3::Zero());
  return out;
}

std::vector<std::string> column_names(PoseFeedback feedback) {
  const FrameResult result = result_with(feedback);
  std::vector<std::string> out;
  visit_columns(result, [&](const char* name, const auto&) { out.emplace_back(name); });
  return out;
}

std::int64_t count_in(double value, double least, double most, const char* column, const SourceLocation& where) {
  if (value >= least && value <= most) return static_cast<std::int64_t>(value);
  throw InputError(where, column, "out of range", "expected a forces.csv as reamsim wrote it");
}

/// Sets `result` from a row in the order of its columns. A value that is missing stays as it is.
void set_values(const std::vector<double>& row, const SourceLocation& where, FrameResult& result) {
  // Counts up to here are whole numbers of a double.
  constexpr double kLargestCount = 1e15, kLargestPass = 1e4;
  const double* next = row.data();
  visit_columns(result, [&](const char* name, auto& value) {
    using Value = std::remove_reference_t<decltype(value)>;
    const double read = *next++;
    if (std::isnan(read)) return;
    if constexpr (std::is_same_v<Value, double>) {
      value = read;
    } else if constexpr (std::is_same_v<Value, int>) {
      value = static_cast<int>(count_in(read, 1, kLargestPass, name, where));
    } else {
      value = count_in(read, 0, kLargestCount, name, where);
    }
  });
}

/// Throws InputError for a pose that no run writes. Its quaternion is normalized.
void check_pose(ToolPose& pose, const SourceLocation& where) {
  if (!(pose.position_mm.cwiseAbs().maxCoeff() <= kFarthest_mm)) {
    throw InputError(where, "tool_x_mm", "the position of the tool is out of range",
                     fmt::format("expected at most {:g} mm", kFarthest_mm));
  }
  if (std::abs(pose.orientation.norm() - 1) > 1e-3) {
    throw InputError(where, "tool_qw", "the quaternion does not have length 1", "expected a rotation");
  }
  pose.orientation.normalize();
}

class LayerMeans {
 public:
  explicit LayerMeans(double travel_mm) : travel_mm_(travel_mm), mean_(travel_mm) {}

  void set(ForceRow& row) {
    const bool single = travel_mm_ == 0;
    const auto means = single ? LayerMean::Means{row.axial_force_n, row.spin_torque_nmm, 1}
                              : mean_.add(row.pose.position_mm, row.axial_force_n, row.spin_torque_nmm);
    row.layer_axial_force_n = means.axial_force_n;
    row.layer_spin_torque_nmm = means.spin_torque_nmm;
    row.layer_force_n = single ? row.force_n : Vec3(means.axial_force_n * (row.pose.orientation * Vec3::UnitZ()));
    row.layer_frames = means.frames;
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
constexpr std::int64_t kMaxBuckets = 4096;

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
  rows_.push_back(row);
  numbers_.push_back(count_++);
  if (rows_.size() <= limit_) return;
  reduce();
  limit_ = rows_.size() + most_rows_;
}

std::vector<ForceRow> RowDecimator::finish() {
  if (bucket_rows_ > 1) reduce();
  if (!rows_.empty() && rows_.back().frame != last_.frame) rows_.push_back(last_);
  return std::move(rows_);
}

void RowDecimator::reduce() {
  const std::int64_t buckets = bucket_rows_ == 1 ? kMaxBuckets / 2 : kMaxBuckets;
  bucket_rows_ = std::max<std::int64_t>(bucket_rows_, 2);
  while (count_ > buckets * bucket_rows_) bucket_rows_ *= 2;
  std::vector<bool> chosen(rows_.size(), false);
  for (std::size_t begin = 0, end = 0; begin < rows_.size(); begin = end) {
    while (end < rows_.size() && numbers_[end] / bucket_rows_ == numbers_[begin] / bucket_rows_) ++end;
    chosen[begin] = true;
    const std::span<const ForceRow> bucket(&rows_[begin], end - begin);
    for (const auto quantity : kQuantities) {
      const auto [least, most] = std::ranges::minmax_element(bucket, {}, quantity);
      chosen[begin + static_cast<std::size_t>(least - bucket.begin())] = true;
      chosen[begin + static_cast<std::size_t>(most - bucket.begin())] = true;
    }
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    if (!chosen[i] && !std::ranges::binary_search(keep_, rows_[i].frame)) continue;
    rows_[kept] = rows_[i];
    numbers_[kept++] = numbers_[i];
  }
  rows_.resize(kept);
  numbers_.resize(kept);
}

const ForceRow& ForceLog::at(std::int64_t frame, const std::string& path) const {
  const auto after = std::ranges::upper_bound(rows, frame, {}, &ForceRow::frame);
  if (after == rows.begin()) return rows.front();
  const ForceRow& row = *std::prev(after);
  if (row.frame != frame) {
    throw InputError({path, 0, 0}, "frame", "no row for frame " + std::to_string(frame) + " of snapshots/",
                     "run the scenario again");
  }
  return row;
}

void for_each_force_row(const std::string& path, const std::function<void(const ForceRow&)>& visit) {
  // Neither figures nor pictures need some of the columns, and logs of older versions have no passes.
  constexpr std::array<std::string_view, 6> kOptional{"spin_rpm",     "torque_x_nmm", "torque_y_nmm",
                                                      "torque_z_nmm", "contacts",     "pass"};
  const std::size_t push = column_names({}).size(), springs = column_names({.push = true}).size();
  constexpr PoseFeedback kAll{.push = true, .springs = true};
  CsvLayout layout;
  for (const std::string& name : column_names(kAll)) {
    const bool optional = layout.columns.size() >= push || std::ranges::count(kOptional, name) > 0;
    layout.columns.push_back({.name = name, .number = 0, .may_be_missing = optional});
  }
  std::error_code ignored;
  layout.killed_writer = std::filesystem::weakly_canonical(path, ignored).parent_path().extension() == ".partial";
  CsvReader table(path, layout, "the forces.csv of a run");
  double removed_mm3 = 0, energy_mj = 0, floor_mj = 0;
  std::int64_t before = -1;
  for (std::vector<double> values; table.next(values);) {
    ForceRow row{result_with(kAll)};
    set_values(values, table.where(), row);
    check_pose(row.pose, table.where());
    if (row.frame <= before) {
      throw InputError(table.where(), "frame", "frames are not in ascending order", "the forces.csv of a run");
    }
    before = row.frame;
    const auto is_missing = [](double value) { return std::isnan(value); };
    const auto values_of_push = std::span(values).subspan(push, springs - push);
    if (std::ranges::any_of(values_of_push, is_missing)) row.push.reset();
    if (std::ranges::any_of(std::span(values).subspan(springs), is_missing)) row.deflection_mm.reset();
    row.removed_mm3 = removed_mm3 += row.removed_mm3;
    row.cumulative_energy_mj = energy_mj += row.energy_mj;
    row.cumulative_floor_mj = floor_mj += row.floor_energy_mj;
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

KeyResults key_results_of(const ForceLog& log) {
  KeyResults out{.means = log.mean_travel_mm > 0};
  for (const ForceRow& row : log.rows) {
    out.peak_axial_force_n = std::max(out.peak_axial_force_n, row.layer_axial_force_n);
    out.peak_spin_torque_nmm = std::max(out.peak_spin_torque_nmm, std::abs(row.layer_spin_torque_nmm));
    out.tool_depth_mm = std::max(out.tool_depth_mm, row.depth_mm);
  }
  return out;
}

std::string force_columns(PoseFeedback feedback) {
  return fmt::format("{}", fmt::join(column_names(feedback), ","));
}

std::vector<double> force_row(const FrameResult& result) {
  std::vector<double> out;
  visit_columns(result, [&](const char*, auto value) { out.push_back(static_cast<double>(value)); });
  return out;
}

void for_each_result(const std::string& path, PoseFeedback feedback,
                     const std::function<void(const FrameResult&)>& visit) {
  const std::string columns = force_columns(feedback);
  CsvReader log(path, csv_cells(columns), "the log of a run");
  FrameResult result = result_with(feedback);
  for (std::vector<double> row; log.next(row);) {
    set_values(row, log.where(), result);
    visit(result);
  }
}

}  // namespace reamsim
