// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/pose_sequence.h"

#include <utility>

namespace reamsim {

namespace {

class StoredPoses final : public PoseSource {
 public:
  explicit StoredPoses(std::vector<ToolPose> poses) : poses_(std::move(poses)) {}
  [[nodiscard]] std::size_t size() const override { return poses_.size(); }
  [[nodiscard]] ToolPose pose(std::size_t k) const override { return poses_[k]; }

 private:
  std::vector<ToolPose> poses_;
};

}  // namespace

ToolPose interpolate(const ToolPose& a, const ToolPose& b, double t) {
  ToolPose pose;
  pose.position_mm = a.position_mm + t * (b.position_mm - a.position_mm);
  pose.orientation = a.orientation.slerp(t, b.orientation).normalized();
  pose.spin_angle_rad = a.spin_angle_rad + t * (b.spin_angle_rad - a.spin_angle_rad);
  pose.spin_rpm = a.spin_rpm + t * (b.spin_rpm - a.spin_rpm);
  return pose;
}

PoseSequence::PoseSequence(std::vector<ToolPose> poses)
    : PoseSequence(std::make_shared<const StoredPoses>(std::move(poses))) {}

PoseSequence::PoseSequence(std::shared_ptr<const PoseSource> source)
    : source_(std::move(source)), size_(source_->size()) {}

PoseSequence PoseSequence::part(std::size_t first, std::size_t count) const {
  PoseSequence out = *this;
  out.first_ += first;
  out.size_ = count;
  return out;
}

std::vector<ToolPose> PoseSequence::all() const {
  std::vector<ToolPose> out;
  out.reserve(size_);
  for (const ToolPose& pose : *this) out.push_back(pose);
  return out;
}

}  // namespace reamsim
