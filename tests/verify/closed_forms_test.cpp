// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The suite's closed forms against the figures of docs/physics.md, 6, and against plain numerical integrals.
#include "sim/verify/closed_forms.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/tool/profile.h"
#include "sim/verify/scene.h"

namespace reamsim::verify {
namespace {

constexpr SteadyPlunge kBall{29, 15, 1.25, 250, 0.2, 1.8};

TEST(Forms, TheDesignsExample) {
  EXPECT_NEAR(kBall.torque_nmm(), 804.4, 0.05);
  EXPECT_NEAR(kBall.axial_force_n(), 47.1, 0.05);
  EXPECT_NEAR(kBall.full_contact_mm(), 4.18, 0.005);
}

TEST(Forms, TheWorkOfSpinAndFeedIsTheCutsEnergy) {
  for (const double feed : {0.2, 2.0}) {
    SteadyPlunge plunge = kBall;
    plunge.feed_mm_s = feed;
    const PlungeLoads loads = plunge.full_loads();
    const double power = loads.torque_nmm * angular_speed(plunge.rpm) + loads.axial_force_n * feed;
    EXPECT_NEAR(power / (specific_energy(1.8) * plunge.removal_mm3_s()), 1, 1e-9);
  }
}

TEST(Forms, TheFullIntegralTendsToTheClosedForms) {
  SteadyPlunge slow = kBall;
  slow.feed_mm_s = 1e-4;
  EXPECT_NEAR(slow.full_loads().torque_nmm / slow.torque_nmm(), 1, 1e-6);
  EXPECT_NEAR(slow.full_loads().axial_force_n / slow.axial_force_n(), 1, 1e-6);
  slow.radius_mm = std::nullopt;
  EXPECT_NEAR(slow.full_loads().axial_force_n / slow.axial_force_n(), 1, 1e-6);
}

TEST(Forms, TorqueOverThrustHasNoDensityInIt) {
  EXPECT_NEAR(kBall.ratio_mm(), 17.12, 0.005);
  for (const double density : {0.3, 1.0, 1.8}) {
    SteadyPlunge slow = kBall;
    slow.density_g_cm3 = density;
    slow.feed_mm_s = 1e-4;
    const PlungeLoads loads = slow.full_loads();
    EXPECT_NEAR(loads.torque_nmm / loads.axial_force_n / kBall.ratio_mm(), 1, 1e-4) << density;
  }
}

TEST(Forms, HalfAFaceByElements) {
  // The law, element by element over the half with x > 0: F = −F_t·v̂ − k_n·F_t·n⊥ at its place.
  constexpr int kRings = 400, kSectors = 400;
  SteadyPlunge plunge = kBall;
  plunge.feed_mm_s = 0.5;
  const double omega = angular_speed(plunge.rpm), u = specific_energy(plunge.density_g_cm3);
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
  for (int i = 0; i < kRings; ++i) {
    const double dr = (15 - 1.25) / kRings, r = 1.25 + (i + 0.5) * dr;
    for (int j = 0; j < kSectors; ++j) {
      const double step = M_PI / kSectors, phi = -M_PI / 2 + (j + 0.5) * step;
      const Vec3 place(r * std::cos(phi), r * std::sin(phi), 29 - std::sqrt(29 * 29 - r * r));
      const Vec3 velocity = Vec3(0, 0, -omega).cross(place) + Vec3(0, 0, -plunge.feed_mm_s);
      const Vec3 along = velocity.normalized(), normal = (place - Vec3(0, 0, 29)) / 29;
      const double tangential = u * plunge.feed_mm_s * r * dr * step / velocity.norm();
      const Vec3 part = -tangential * along - kNormalRatio * tangential * (normal - normal.dot(along) * along);
      force += part;
      moment += place.cross(part);
    }
  }
  const HalfFaceLoads half = plunge.full_half_face();
  EXPECT_NEAR(half.along_e_n / force.x(), 1, 1e-4);
  EXPECT_NEAR(half.along_t_n / force.y(), 1, 1e-4);
  EXPECT_NEAR(half.axial_force_n / force.z(), 1, 1e-4);
  EXPECT_NEAR(half.about_e_nmm / moment.x(), 1, 1e-4);
  EXPECT_NEAR(half.about_t_nmm / moment.y(), 1, 1e-4);
  EXPECT_NEAR(half.torque_nmm / moment.z(), 1, 1e-4) << "the bone turns the tool back, about +z";
}

TEST(Forms, TheHalfFacesIntegralTendsToItsClosedForms) {
  SteadyPlunge slow = kBall;
  slow.feed_mm_s = 1e-4;
  const HalfFaceLoads half = slow.half_face(), full = slow.full_half_face();
  EXPECT_NEAR(full.torque_nmm / half.torque_nmm, 1, 1e-4);
  EXPECT_NEAR(full.axial_force_n / half.axial_force_n, 1, 1e-4);
  EXPECT_NEAR(full.along_e_n / half.along_e_n, 1, 1e-4);
  EXPECT_NEAR(full.along_t_n / half.along_t_n, 1, 1e-4);
  EXPECT_NEAR(full.about_e_nmm / half.about_e_nmm, 1, 1e-4);
  EXPECT_NEAR(full.about_t_nmm / half.about_t_nmm, 1, 1e-4);
  EXPECT_NEAR(half.about_t_nmm, 29 * half.along_e_n, 1e-9) << "normals meet in the sphere's centre";
}

TEST(Forms, CapAndSegmentBySlices) {
  constexpr int kSlices = 100000;
  double cap = 0, segment = 0;
  for (int i = 0; i < kSlices; ++i) {
    const double below = 3 * (i + 0.5) / kSlices, half2 = 64 - std::pow(8 - 3 + below, 2);
    cap += M_PI * half2 * 3 / kSlices;
    segment += 2 * std::sqrt(half2) * 3 / kSlices;
  }
  EXPECT_NEAR(cap_mm3(8, 3), cap, 1e-6);
  EXPECT_NEAR(segment_mm2(8, 3), segment, 1e-5);
}

TEST(Forms, TheToolsAreTakenAsTheirCurves) {
  const Outline ball = fit_outline(ball_profile(29, 0.05));
  ASSERT_EQ(ball.arcs.size(), 2U);
  for (const OutlineArc& arc : ball.arcs) EXPECT_NEAR(arc.curvature, 1.0 / 29, 1e-10);
  const Outline head = fit_outline(convex_profile(29, 15, 1.25, 8, 0.05));
  ASSERT_EQ(head.arcs.size(), 4U);
  EXPECT_NEAR(head.arcs[0].curvature, 1.0 / 29, 1e-10);
  EXPECT_NEAR(head.arcs[0].begin.x(), 1.25, 1e-12);
  EXPECT_NEAR(head.arcs[0].begin.y(), 29 - std::sqrt(29 * 29 - 1.25 * 1.25), 1e-12);
  EXPECT_NEAR(head.arcs[0].end.x(), 15, 1e-12);
  EXPECT_NEAR(head.arcs[0].end.y(), kBall.full_contact_mm(), 1e-12);
}

}  // namespace
}  // namespace reamsim::verify
