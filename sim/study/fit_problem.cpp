// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/fit_problem.h"

#include <algorithm>
#include <cmath>

#include "sim/base/error.h"

namespace reamsim {

namespace {

/// A measured time that is nearer to a frame's is taken as that frame's, s.
constexpr double kSameTime_s = 1e-9;

Vec3 values_of(const float* values) {
  return {double{values[0]}, double{values[1]}, double{values[2]}};
}

}  // namespace

double channel_value(ForceChannel channel, const Vec3& force, const Vec3& torque, const Vec3& tool_z) {
  const int i = static_cast<int>(channel);
  if (i < 3) return force[i];
  if (i < 6) return torque[i - 3];
  return (channel == ForceChannel::axial_force ? force : torque).dot(tool_z);
}

FitProblem::FitProblem(const ForceBasis& basis, const std::vector<FrameTime>& frames, const MeasuredForces& measured,
                       std::vector<std::vector<int>> units)
    : units_(std::move(units)), unit_of_grade_(256, -1), has_edge_(basis.has_edge()) {
  columns_ = static_cast<Eigen::Index>(2 * units_.size() + (has_edge_ ? 2 : 0));
  for (std::size_t unit = 0; unit < units_.size(); ++unit)
    for (const int grade : units_[unit]) unit_of_grade_[static_cast<std::size_t>(grade)] = static_cast<int>(unit);
  for (const ForceChannel channel : measured.channels) {
    channels_.push_back({.channel = channel,
                         .gram = Eigen::MatrixXd::Zero(columns_, columns_),
                         .right = Eigen::VectorXd::Zero(columns_)});
  }
  for (std::size_t at = 0; at < measured.time_s.size(); ++at) {
    const double time = measured.time_s[at];
    const auto after = std::ranges::lower_bound(frames, time - kSameTime_s, {}, &FrameTime::time_s);
    if (after == frames.end()) break;
    if (after == frames.begin() && after->time_s > time + kSameTime_s) continue;
    Eigen::MatrixXd parts = parts_at(basis, *after);
    if (after->time_s > time + kSameTime_s) {
      const FrameTime& before = *(after - 1);
      const double t = (time - before.time_s) / (after->time_s - before.time_s);
      parts = (1 - t) * parts_at(basis, before) + t * parts;
    }
    if (!parts.isZero(0)) add_sample(parts, measured, at);
  }
  if (samples() == 0) {
    throw InputError({}, "", "no measured time lies in the time of contact of the run",
                     "shift time_s so that it begins with the run");
  }
}

/// By channel (rows) and column.
Eigen::MatrixXd FitProblem::parts_at(const ForceBasis& basis, const FrameTime& frame) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(channels_.size()), columns_);
  const auto count = static_cast<Eigen::Index>(units_.size());
  for (const BasisRow& row : basis.of(frame.frame)) {
    const int unit = unit_of_grade_[static_cast<std::size_t>(row.grade)];
    if (row.grade != 0 && unit < 0) continue;
    const Eigen::Index p = row.grade == 0 ? 2 * count : unit, n = row.grade == 0 ? 2 * count + 1 : count + unit;
    for (std::size_t c = 0; c < channels_.size(); ++c) {
      const auto i = static_cast<Eigen::Index>(c);
      const ForceChannel channel = channels_[c].channel;
      out(i, p) += channel_value(channel, values_of(row.p_mm2), values_of(row.p_torque_mm3), frame.tool_z);
      out(i, n) += channel_value(channel, values_of(row.n_mm2), values_of(row.n_torque_mm3), frame.tool_z);
    }
  }
  return out;
}

void FitProblem::add_sample(const Eigen::MatrixXd& parts, const MeasuredForces& measured, std::size_t at) {
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    const double value = measured.values[c][at];
    if (std::isnan(value)) continue;
    Channel& channel = channels_[c];
    const Eigen::VectorXd part = parts.row(static_cast<Eigen::Index>(c)).transpose();
    channel.gram.selfadjointView<Eigen::Lower>().rankUpdate(part);
    channel.right += value * part;
    channel.samples += 1;
    channel.sum += value;
    channel.squares += value * value;
  }
}

std::size_t FitProblem::samples() const {
  std::size_t out = 0;
  for (const Channel& channel : channels_) out += channel.samples;
  return out;
}

void FitProblem::weigh(const Eigen::VectorXd* coefficients, double floor) {
  gram_ = Eigen::MatrixXd::Zero(columns_, columns_);
  right_ = Eigen::VectorXd::Zero(columns_);
  squares_ = 0;
  for (Channel& channel : channels_) {
    if (coefficients == nullptr) channel.gram = Eigen::MatrixXd(channel.gram.selfadjointView<Eigen::Lower>());
    const auto count = static_cast<double>(channel.samples);
    const double least = floor * floor * channel.squares;
    const double rest =
        std::max(coefficients == nullptr ? channel.squares : channel.residual_squares(*coefficients), least);
    if (!(rest > 0)) continue;  // no samples, or zeros only
    const double weight = count / rest;
    gram_ += weight * channel.gram;
    right_ += weight * channel.right;
    squares_ += weight * channel.squares;
  }
}

double FitProblem::squares(const Eigen::VectorXd& coefficients) const {
  return std::max(0.0, squares_ - 2 * coefficients.dot(right_) + coefficients.dot(gram_ * coefficients));
}

std::vector<ChannelResidual> FitProblem::residuals(const Eigen::VectorXd& coefficients) const {
  std::vector<ChannelResidual> out;
  for (const Channel& channel : channels_) {
    const auto count = static_cast<double>(std::max<std::size_t>(channel.samples, 1));
    const double rest = channel.residual_squares(coefficients);
    const double variance = channel.squares - channel.sum * channel.sum / count;
    out.push_back({.channel = channel.channel,
                   .samples = channel.samples,
                   .rms_measured = std::sqrt(channel.squares / count),
                   .rms = std::sqrt(rest / count),
                   .r_squared = variance > 0 ? 1 - rest / variance : 0});
  }
  return out;
}

}  // namespace reamsim
