// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <Eigen/Geometry>
#include <array>
#include <limits>

namespace reamsim {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Vec3i = Eigen::Vector3i;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;
/// A rigid transform. Every variable of this type is named `target_from_source`.
using Rigid = Eigen::Isometry3d;

/// Axis-aligned box, mm, in the frame that its owner names.
struct Aabb {
  Vec3 min = Vec3::Zero();
  Vec3 max = Vec3::Zero();

  [[nodiscard]] Vec3 center() const { return 0.5 * (min + max); }
  [[nodiscard]] Vec3 half() const { return 0.5 * (max - min); }
  /// The box with `margin` added on every side.
  [[nodiscard]] Aabb expanded(double margin) const {
    return {min - Vec3::Constant(margin), max + Vec3::Constant(margin)};
  }
  [[nodiscard]] bool empty() const { return (min.array() > max.array()).any(); }
  /// Corner 0…7: bit n of the number chooses the maximum along axis n.
  [[nodiscard]] Vec3 corner(int n) const {
    return {(n & 1) != 0 ? max.x() : min.x(), (n & 2) != 0 ? max.y() : min.y(), (n & 4) != 0 ? max.z() : min.z()};
  }
  void extend(const Vec3& point) {
    min = min.cwiseMin(point);
    max = max.cwiseMax(point);
  }
  /// Contains no point; extend() makes it grow.
  static Aabb none() {
    return {Vec3::Constant(std::numeric_limits<double>::infinity()),
            Vec3::Constant(-std::numeric_limits<double>::infinity())};
  }
};

/// The glenoid frame G: origin at the glenoid centre, +z out of the bone along the face normal, +y superior,
/// right-handed. Lengths in mm.
struct GlenoidFrame {
  Rigid bone_from_glenoid = Rigid::Identity();
};

/// The directions of the scapular frame S in B, each of length 1: version and inclination are angles between them.
struct ScapularAxes {
  Vec3 lateral = Vec3::UnitX();   ///< along the Friedman axis, from the trigonum spinae to the glenoid's centre
  Vec3 superior = Vec3::UnitY();  ///< in the scapular plane
  Vec3 anterior = Vec3::UnitZ();
};

/// The rotation by the smallest angle that takes direction `from` to direction `to`; where they are opposite, about any
/// axis across them. Eigen's FromTwoVectors takes six seconds to compile, for a singular value decomposition in that
/// case.
Quat smallest_rotation(const Vec3& from, const Vec3& to);

}  // namespace reamsim
