// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <deque>

#include "sim/base/geometry.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// The tool travel over which displayed forces are averaged, mm: a voxel where voxels are removed as a whole, which
/// makes forces spike; 0 where they are clipped.
inline double averaged_travel_mm(const CuttingSettings& cutting, double voxel_mm) {
  return cutting.erosion == ErosionMode::exact ? 0 : voxel_mm;
}

/// Running means of axial force and spin torque over the last voxel of the tool's travel. Where voxels are removed
/// whole, single frames are spikes; only a mean over one layer of voxels compares with a measurement (docs/erosion.md).
class LayerMean {
 public:
  explicit LayerMean(double voxel_mm) : voxel_mm_(voxel_mm) {}

  struct Means {
    double axial_force_n = 0;
    double spin_torque_nmm = 0;
    std::size_t frames = 0;  ///< number of frames in the means
  };

  /// Adds the next frame: the tool's position in B, its force and its torque. Returns the means over the frames of the
  /// last voxel of travel, this one included; zero until the tool has travelled a voxel. While the tool stands still
  /// the number of frames stays constant.
  Means add(const Vec3& position_mm, double axial_force_n, double spin_torque_nmm);

 private:
  /// A frame, or several successive ones where there are very many: their sums.
  struct Frame {
    double path_mm = 0;  ///< length of the path at the end of the frame
    Means values;
  };

  void drop_oldest();
  /// Keeps the number of frames constant for one more that the tool stands still.
  void drop_while_still();
  void append(double path_mm, double axial_force_n, double spin_torque_nmm);
  void merge_pairs();

  double voxel_mm_;
  Vec3 last_mm_ = Vec3::Zero();
  std::deque<Frame> frames_;
  std::size_t frames_per_entry_ = 1;
  std::size_t still_frames_ = 0;  ///< for which no frame has been dropped yet
  Means sums_;
  bool full_ = false;
};

}  // namespace reamsim
