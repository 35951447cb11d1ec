// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "sim/anatomy/find_glenoid.h"
#include "sim/bone/phantom.h"
#include "tests/bone/bone_fixture.h"

namespace reamsim::test {

inline double angle_deg(const Vec3& a, const Vec3& b) {
  return std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0, 1.0)) * 180 / std::numbers::pi;
}

/// B of a left phantom (x left, y posterior, z superior) and anatomical coordinates (lateral, superior, anterior).
inline Vec3 anatomy_from_left(const Vec3& p) {
  return {p.x(), p.z(), -p.y()};
}
inline Vec3 left_from_anatomy(const Vec3& p) {
  return {p.x(), -p.z(), p.y()};
}

/// Centre and normal of a face. B.
struct FaceTruth {
  Vec3 center_mm;
  Vec3 normal;
};

/// The frame of a deeply worn phantom (A2) lies on its Friedman axis, which deviates from the middle of the face with
/// the depth of the wear. The truth here is by the definition of find_glenoid(), from closed forms: the middle of the
/// pear that fits the middle of the rounded edge, on the ball that wore the face, whose centre the normal points to.
inline FaceTruth worn_truth(const GlenoidShape& shape) {
  const GlenoidFace::Ball& ball = shape.face().balls.back();
  const Vec3 head = left_from_anatomy(ball.center_mm);
  Vec3 center = left_from_anatomy(shape.face().center_mm);
  constexpr int kTurns = 30;
  for (int turn = 0; turn < kTurns; ++turn) {
    const Rigid frame = frame_at(center, (head - center).normalized());
    std::vector<Vec2> rim;
    for (const Vec3& p : shape.rim_mm(true)) rim.push_back((frame.inverse() * left_from_anatomy(p)).head<2>());
    const Vec2 middle = fit_pear(rim)->outline.center_mm;
    const Vec2 from_head = middle - (frame.inverse() * head).head<2>();
    const double depth = ball.radius_mm - std::sqrt(ball.radius_mm * ball.radius_mm - from_head.squaredNorm());
    center = frame * Vec3(middle.x(), middle.y(), depth);
  }
  return {center, (head - center).normalized()};
}

/// A2: worn_truth(). B2: the centre of the phantom, and the plane through its rim. Others: the frame of the phantom.
inline FaceTruth truth_of(const PhantomSettings& settings) {
  const GlenoidShape shape(settings);
  if (settings.walch == Walch::a2) return worn_truth(shape);
  FaceTruth out{left_from_anatomy(shape.face().center_mm), left_from_anatomy(shape.face().normal)};
  if (settings.walch != Walch::b2) return out;
  std::vector<Vec3> rim;
  for (const Vec3& p : shape.rim_mm()) rim.push_back(left_from_anatomy(p));
  out.normal = fit_plane(rim, out.normal)->normal;
  return out;
}

}  // namespace reamsim::test
