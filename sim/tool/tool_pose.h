// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

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

}  // namespace reamsim
