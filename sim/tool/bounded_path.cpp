// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/bounded_path.h"

#include <algorithm>
#include <utility>

namespace reamsim {

BoundedPath::BoundedPath(double reach_mm, double step_mm, std::vector<std::int64_t> keep, std::size_t most)
    : reach_mm_(reach_mm), step_mm_(step_mm), keep_(std::move(keep)), most_(most) {}

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

void BoundedPath::add(const PoseSequence& poses) {
  for (std::size_t k = 0; k < poses.size(); ++k) add(poses[k], k);
}

std::vector<PathSample> BoundedPath::finish() {
  if (chooser_) {
    const std::optional<PathSample> last = chooser_->last();
    append(chooser_->finish());
    if (last && samples_.back().frame != last->frame) samples_.push_back(*last);
    chooser_.reset();
  }
  return std::move(samples_);
}

void BoundedPath::choose(const PathSample& sample) {
  append(chooser_->add(sample, std::ranges::binary_search(keep_, static_cast<std::int64_t>(sample.frame))));
}

void BoundedPath::append(const std::optional<StepChooser::Choice>& choice) {
  if (choice) samples_.push_back(choice->sample);
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
