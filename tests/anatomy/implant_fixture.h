// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <gtest/gtest.h>

#include "sim/mesh/mesh_check.h"
#include "tests/anatomy/reamed_fixture.h"

namespace reamsim::test {

inline constexpr double kTenthVoxel = 0.1 * kVoxel;

/// A flat implant with a round footprint.
inline ImplantSettings disc(double diameter_mm) {
  ImplantSettings out;
  out.diameter_mm = diameter_mm;
  return out;
}

inline double disc_mm2(double radius) {
  return kPi * radius * radius;
}

/// Area of the part of a disc beyond a chord at a distance from its centre, −radius…radius.
inline double segment_mm2(double radius, double distance) {
  return radius * radius * std::acos(distance / radius) - distance * std::sqrt(radius * radius - distance * distance);
}

/// The chord beyond which a disc has this area.
inline double chord_of(double radius, double area_mm2) {
  double low = -radius;
  double high = radius;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (segment_mm2(radius, middle) > area_mm2 ? low : high) = middle;
  }
  return low;
}

inline double sagitta(double radius, double r) {
  return radius - std::sqrt(radius * radius - r * r);
}

/// A block whose top was reamed flat to z = −depth.
inline Block flat_block(const Vec3& size_mm, double depth_mm) {
  Block block(size_mm, kVoxel, 1.8);
  block.ream(above_plane({0, 0, -depth_mm}, Vec3::UnitZ()));
  return block;
}

/// What was there before: removes a solid as if it had never been bone.
inline void carve(Block& block, const Solid& solid) {
  block.ream(solid);
  block.before = block.after.fill;
}

inline Planning plan(const Block& block, const ImplantSettings& implant, const BoneAxes& axes = {}) {
  MetricSettings settings;
  settings.implant = implant;
  const auto found = block.measure(Rigid::Identity(), settings, axes).planning;
  EXPECT_TRUE(found);
  return found.value_or(Planning{});
}

}  // namespace reamsim::test
