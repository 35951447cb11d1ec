// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/tool_path.h"

#include <algorithm>
#include <cmath>

namespace reamsim {

namespace {

void append(const std::optional<StepChooser::Choice>& choice, std::vector<PathSample>& out) {
  if (!choice) return;
  const auto& [last, sample, parts] = *choice;
  for (std::int64_t i = 1; i < parts; ++i) {
    out.push_back({interpolate(last, sample.pose, static_cast<double>(i) / static_cast<double>(parts)), sample.frame});
  }
  out.push_back(sample);
}

}  // namespace

Vec3 rotation_vector(const Quat& a, const Quat& b) {
  const Eigen::AngleAxisd rotation(b * a.conjugate());
  const double angle = rotation.angle() > M_PI ? rotation.angle() - 2 * M_PI : rotation.angle();
  return angle * rotation.axis();
}

double motion_bound_mm(const ToolPose& a, const ToolPose& b, double reach_mm) {
  return (b.position_mm - a.position_mm).norm() + rotation_vector(a.orientation, b.orientation).norm() * reach_mm;
}

ToolPath::ToolPath(std::vector<PathSample> points, double reach_mm)
    : points_(std::move(points)), ends_mm_(points_.size(), 0) {
  for (std::size_t k = 1; k < points_.size(); ++k) {
    ends_mm_[k] = ends_mm_[k - 1] + motion_bound_mm(points_[k - 1].pose, points_[k].pose, reach_mm);
  }
}

std::size_t ToolPath::point_at(double at_mm) const {
  const auto end = std::ranges::lower_bound(ends_mm_, at_mm);
  return std::min(static_cast<std::size_t>(end - ends_mm_.begin()), points_.size() - 1);
}

ToolPose ToolPath::pose_at(double at_mm) const {
  const std::size_t k = point_at(at_mm);
  if (k == 0) return points_[0].pose;
  const double part_mm = ends_mm_[k] - ends_mm_[k - 1];
  const double t = part_mm > 0 ? (at_mm - ends_mm_[k - 1]) / part_mm : 1;
  return interpolate(points_[k - 1].pose, points_[k].pose, std::clamp(t, 0.0, 1.0));
}

std::optional<StepChooser::Choice> StepChooser::add(const PathSample& sample, bool keep) {
  std::optional<Choice> out;
  if (!chosen_) {
    chosen_ = sample.pose;
    before_mm_ = sample.pose.position_mm;
    return out;
  }
  if (pending_) {
    const Vec3 pending_mm = pending_->pose.position_mm;
    out = decide((pending_mm - before_mm_).dot(sample.pose.position_mm - pending_mm) <= 0);
    before_mm_ = pending_mm;
  }
  pending_ = sample;
  keep_pending_ = keep;
  return out;
}

std::optional<StepChooser::Choice> StepChooser::decide(bool reverses) {
  constexpr double kMinStep = 0.1;  // of a step: a tool that moves less dwells
  const double bound_mm = motion_bound_mm(*chosen_, pending_->pose, reach_mm_);
  const auto parts = static_cast<std::int64_t>(std::ceil(bound_mm / step_mm_));
  if (!keep_pending_ && (bound_mm < kMinStep * step_mm_ || (parts == 1 && !reverses))) return std::nullopt;
  const ToolPose last = std::exchange(*chosen_, pending_->pose);
  return Choice{last, *pending_, parts};
}

std::vector<PathSample> sample_path(const std::vector<PathSample>& path, double reach_mm, double step_mm) {
  std::vector<PathSample> out{path.front()};
  StepChooser chooser(reach_mm, step_mm);
  for (const PathSample& sample : path) append(chooser.add(sample), out);
  append(chooser.finish(), out);
  return out;
}

void BoundedPath::add(const ToolPose& pose, std::size_t frame) {
  if (chooser_) {
    choose({pose, frame});
  } else {
    samples_.push_back({pose, frame});
  }
  if (samples_.size() <= most_ + keep_.size()) return;
  if (chooser_) step_mm_ *= 2;
  choose_again();
  // Half of the room is left, so that the work per pose is constant.
  while (samples_.size() > most_ / 2 + keep_.size()) {
    step_mm_ *= 2;
    choose_again();
  }
}

std::vector<PathSample> BoundedPath::finish() {
  if (chooser_) {
    const std::optional<PathSample> last = chooser_->last();
    if (const auto choice = chooser_->finish()) samples_.push_back(choice->sample);
    if (last && samples_.back().frame != last->frame) samples_.push_back(*last);
    chooser_.reset();
  }
  return std::move(samples_);
}

void BoundedPath::choose(const PathSample& sample) {
  const bool keep = std::ranges::binary_search(keep_, static_cast<std::int64_t>(sample.frame));
  if (const auto choice = chooser_->add(sample, keep)) samples_.push_back(choice->sample);
}

void BoundedPath::choose_again() {
  std::vector<PathSample> old = std::move(samples_);
  // The pose that waits for the next one is not among the samples yet.
  if (chooser_) {
    if (const std::optional<PathSample> last = chooser_->last()) old.push_back(*last);
  }
  samples_ = {old.front()};
  thinned_ = true;
  chooser_.emplace(reach_mm_, step_mm_);
  for (const PathSample& sample : old) choose(sample);
}

}  // namespace reamsim
