// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/layer_mean.h"

#include <utility>

namespace reamsim {

namespace {

/// The tool stands still where its step is below this fraction of the mean step.
constexpr double kStillFraction = 0.01;
/// Entries in memory, 2 MB. Where a voxel of travel takes more frames, each entry holds several.
constexpr std::size_t kMaxEntries = 65'536;

}  // namespace

void LayerMean::drop_oldest() {
  sums_.axial_force_n -= frames_.front().values.axial_force_n;
  sums_.spin_torque_nmm -= frames_.front().values.spin_torque_nmm;
  sums_.frames -= frames_.front().values.frames;
  frames_.pop_front();
}

void LayerMean::merge_pairs() {
  std::deque<Frame> pairs;
  for (std::size_t i = 0; i + 1 < frames_.size(); i += 2) {
    const Frame &first = frames_[i], &second = frames_[i + 1];
    pairs.push_back(
        {second.path_mm,
         {first.values.axial_force_n + second.values.axial_force_n,
          first.values.spin_torque_nmm + second.values.spin_torque_nmm, first.values.frames + second.values.frames}});
  }
  if (frames_.size() % 2 == 1) pairs.push_back(frames_.back());
  frames_ = std::move(pairs);
  frames_per_entry_ *= 2;
}

void LayerMean::drop_while_still() {
  ++still_frames_;
  while (!frames_.empty() && still_frames_ >= frames_.front().values.frames) {
    still_frames_ -= frames_.front().values.frames;
    drop_oldest();
  }
}

void LayerMean::append(double path_mm, double axial_force_n, double spin_torque_nmm) {
  if (frames_.empty() || frames_.back().values.frames >= frames_per_entry_) frames_.emplace_back();
  Frame& entry = frames_.back();
  entry.path_mm = path_mm;
  for (Means* means : {&entry.values, &sums_}) {
    means->axial_force_n += axial_force_n;
    means->spin_torque_nmm += spin_torque_nmm;
    ++means->frames;
  }
}

LayerMean::Means LayerMean::add(const Vec3& position_mm, double axial_force_n, double spin_torque_nmm) {
  const double step = frames_.empty() ? 0 : (position_mm - last_mm_).norm();
  const double path = frames_.empty() ? 0 : frames_.back().path_mm + step;
  if (full_ && step * static_cast<double>(sums_.frames) < kStillFraction * voxel_mm_) drop_while_still();
  last_mm_ = position_mm;
  append(path, axial_force_n, spin_torque_nmm);
  // A frame is dropped when the travel after its end amounts to a voxel.
  while (frames_.size() > 1 && path - frames_.front().path_mm >= voxel_mm_ * (1 - 1e-9)) {
    drop_oldest();
    full_ = true;
  }
  if (frames_.size() > kMaxEntries) merge_pairs();
  if (frames_per_entry_ > 1 && frames_.size() < kMaxEntries / 4) frames_per_entry_ /= 2;
  if (!full_) return {};
  const auto count = static_cast<double>(sums_.frames);
  return {sums_.axial_force_n / count, sums_.spin_torque_nmm / count, sums_.frames};
}

}  // namespace reamsim
