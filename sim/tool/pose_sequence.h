// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <vector>

#include "sim/base/geometry.h"

namespace reamsim {

/// The pose of the tool: frame T in B without the spin, and the spin about −z of T.
struct ToolPose {
  Vec3 position_mm = Vec3::Zero();
  Quat orientation = Quat::Identity();
  double spin_angle_rad = 0;  ///< accumulated, positive clockwise seen from the drive
  double spin_rpm = 0;

  [[nodiscard]] Rigid bone_from_tool() const {
    Rigid out = Rigid::Identity();
    out.linear() = orientation.toRotationMatrix();
    out.translation() = position_mm;
    return out;
  }
};

/// The pose at fraction `t` (0…1) between `a` and `b`: orientation spherically, all else linearly.
ToolPose interpolate(const ToolPose& a, const ToolPose& b, double t);

/// Computes the poses of a motion. Any thread may call the methods.
class PoseSource {
 public:
  virtual ~PoseSource() = default;
  [[nodiscard]] virtual std::size_t size() const = 0;
  /// `k` < size(). Throws RunError when a file that holds the poses cannot be read any more.
  [[nodiscard]] virtual ToolPose pose(std::size_t k) const = 0;
};

/// The poses of a motion, one per frame. They are computed when asked for, so that memory does not depend on their
/// number. Immutable; copies share the source, and any thread may read.
class PoseSequence {
 public:
  class Iterator {
   public:
    using iterator_category = std::input_iterator_tag;
    using value_type = ToolPose;
    using difference_type = std::ptrdiff_t;
    using pointer = const ToolPose*;
    using reference = ToolPose;

    Iterator(const PoseSequence& poses, std::size_t at) : poses_(&poses), at_(at) {}
    ToolPose operator*() const { return (*poses_)[at_]; }
    Iterator& operator++() {
      ++at_;
      return *this;
    }
    bool operator==(const Iterator& other) const { return at_ == other.at_; }

   private:
    const PoseSequence* poses_;
    std::size_t at_;
  };

  PoseSequence() = default;
  PoseSequence(std::vector<ToolPose> poses);  // implicit
  PoseSequence(std::initializer_list<ToolPose> poses) : PoseSequence(std::vector(poses)) {}
  explicit PoseSequence(std::shared_ptr<const PoseSource> source);

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  ToolPose operator[](std::size_t k) const { return source_->pose(first_ + k); }
  [[nodiscard]] ToolPose front() const { return (*this)[0]; }
  [[nodiscard]] ToolPose back() const { return (*this)[size_ - 1]; }
  [[nodiscard]] Iterator begin() const { return {*this, 0}; }
  [[nodiscard]] Iterator end() const { return {*this, size_}; }

  /// `count` poses from `first` on, which becomes pose 0.
  [[nodiscard]] PoseSequence part(std::size_t first, std::size_t count) const;
  /// All poses in memory.
  [[nodiscard]] std::vector<ToolPose> all() const;

 private:
  std::shared_ptr<const PoseSource> source_;
  std::size_t first_ = 0;
  std::size_t size_ = 0;
};

}  // namespace reamsim
