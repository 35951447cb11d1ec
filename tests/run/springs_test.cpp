// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The balance of springs (sim/run/balance.h) on bones that are functions.
#include "sim/run/balance.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/scenario/motion_settings.h"

namespace reamsim::springs_tests {
namespace {

constexpr double kFrame_s = 1e-3, kRigid_n_mm = ComplianceSettings::kRigid_n_mm;

SpringBalance fed(const Vec3& stiffness_n_mm, double damping_n_s_mm = 0) {
  return {.stiffness_n_mm = stiffness_n_mm,
          .damping_n_s_mm = damping_n_s_mm,
          .planned_mm = {0, 0, -1e-3},
          .duration_s = kFrame_s,
          .most_mm = 0.1,
          .least_mm = 1e-5};
}

/// A bone that resists with a matrix, N·s/mm, within contact.
BoneForces damper(const SpringBalance& b, const SpringState& from, const Mat3& resistance) {
  const Vec3 before = from.deflection_mm;
  return [=](const std::vector<Vec3>& tried) {
    std::vector<Vec3> out;
    for (const Vec3& mm : tried) out.emplace_back(-resistance * (b.planned_mm + mm - before) / b.duration_s);
    return out;
  };
}

/// Lateral motion turns the force, as one-sided contact does (docs/feeds.md, 11).
Mat3 one_sided() {
  Mat3 out;
  out << 40, 90, 10, -90, 40, -80, 15, 0, 200;
  return out;
}

SpringState after(const SpringBalance& b, const Mat3& resistance, int frames, int* evaluations = nullptr) {
  SpringState state;
  for (int i = 0; i < frames; ++i) {
    const Deflection now = balanced_deflection(b, damper(b, state, resistance), state);
    EXPECT_TRUE(now.balanced) << i;
    if (evaluations != nullptr) *evaluations += now.evaluations;
    add_spring_energies(b, now, {.bone_n = now.bone_n}, state);
  }
  return state;
}

TEST(Springs, LinearBoneIsImplicitEulerOfItsEquation) {
  const SpringBalance b = fed({50, 80, 120}, 3);
  const Mat3 resistance = one_sided();
  int evaluations = 0;
  const SpringState state = after(b, resistance, 300, &evaluations);
  Vec3 expected = Vec3::Zero();  // (K + (C + A)/Δt)·d = (C + A)/Δt·d_before − A·v
  const Mat3 rate = (resistance + 3 * Mat3::Identity()) / kFrame_s;
  const Mat3 left = rate + Mat3(b.stiffness_n_mm.asDiagonal());
  for (int i = 0; i < 300; ++i) expected = left.inverse() * (rate * expected - resistance * b.planned_mm / kFrame_s);
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(state.deflection_mm[axis], expected[axis], 2e-3 * expected.norm());
  EXPECT_LT(evaluations, 330) << "about one a frame";
}

TEST(Springs, RigidAxesDoNotDeflect) {
  const SpringState state = after(fed({50, kRigid_n_mm, kRigid_n_mm}), one_sided(), 100);
  EXPECT_EQ(state.deflection_mm[1], 0);
  EXPECT_EQ(state.deflection_mm[2], 0);
  EXPECT_GT(state.deflection_mm[0], 0);
}

TEST(Springs, BoneThatEndsLeavesThemAndTheyReturn) {
  SpringBalance b = fed({50, 50, 50}, 1);
  SpringState state = after(b, one_sided(), 50);
  const double contact_mm = state.deflection_mm.norm();
  const BoneForces air = [](const std::vector<Vec3>& tried) { return std::vector<Vec3>(tried.size(), Vec3::Zero()); };
  const Deflection now = balanced_deflection(b, air, state);
  // c/Δt = 1000 N/mm against k = 50 N/mm.
  EXPECT_NEAR(now.mm.norm(), contact_mm / 1.05, 1e-3 * contact_mm);
  EXPECT_TRUE(now.bone_n_s_mm.isZero());
  b.damping_n_s_mm = 0;
  EXPECT_NEAR(balanced_deflection(b, air, state).mm.norm(), 0, 1e-9);
  b.most_mm = 0.5 * contact_mm;
  const Deflection limited = balanced_deflection(b, air, state);
  EXPECT_TRUE(limited.limited);
  EXPECT_NEAR(limited.mm.norm(), 0.5 * contact_mm, 1e-9);
}

TEST(Springs, ForceThatJumpsAcrossTheBalanceIsSaid) {
  const SpringBalance b = fed({kRigid_n_mm, kRigid_n_mm, 100});
  const BoneForces edge = [](const std::vector<Vec3>& tried) {
    std::vector<Vec3> out;
    for (const Vec3& mm : tried) out.emplace_back(0, 0, mm.z() < 0.01 ? 5 : 0);
    return out;
  };
  const Deflection now = balanced_deflection(b, edge, {});
  EXPECT_FALSE(now.balanced);
  EXPECT_LE(now.missing_n, 5);
  EXPECT_GT(now.missing_n, 0.5);
  EXPECT_LE(now.evaluations, 41);
}

TEST(Springs, EnergiesClose) {
  const SpringBalance b = fed({50, 80, 120}, 3);
  SpringState state;
  double bone_mj = 0;
  for (int i = 0; i < 200; ++i) {
    const Vec3 before = state.deflection_mm;
    const Deflection now = balanced_deflection(b, damper(b, state, one_sided()), state);
    bone_mj -= now.bone_n.dot(b.planned_mm + now.mm - before);
    add_spring_energies(b, now, {.bone_n = now.bone_n}, state);
  }
  EXPECT_GT(state.spring_mj, 0);
  EXPECT_GT(state.damping_mj, 0);
  EXPECT_NEAR(state.carriage_mj, bone_mj + state.spring_mj + state.damping_mj + state.lost_mj, 1e-3 * bone_mj);
}

}  // namespace
}  // namespace reamsim::springs_tests
