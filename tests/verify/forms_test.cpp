// The suite's closed forms against the design's figures, and against plain numerical integrals.
#include "sim/verify/forms.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/verify/scene.h"

namespace reamsim::verify {
namespace {

constexpr SteadyPlunge kExample{29, 15, 1.25, 250, 0.2, 1.8};

TEST(Forms, TheDesignsExample) {
  EXPECT_NEAR(kExample.torque_nmm(), 804.4, 0.05);
  EXPECT_NEAR(kExample.thrust_n(), 47.1, 0.05);
  EXPECT_NEAR(kExample.full_contact_mm(), 4.18, 0.005);
}

TEST(Forms, TheWorkOfSpinAndFeedIsTheCutsEnergy) {
  for (const double feed : {0.2, 2.0}) {
    SteadyPlunge plunge = kExample;
    plunge.feed_mm_s = feed;
    const PlungeLoads loads = plunge.full_loads();
    const double power = loads.torque_nmm * angular_speed(plunge.rpm) + loads.thrust_n * feed;
    EXPECT_NEAR(power / (specific_energy(1.8) * plunge.removal_mm3_s()), 1, 1e-9);
  }
}

TEST(Forms, TheFullIntegralTendsToTheClosedForms) {
  SteadyPlunge slow = kExample;
  slow.feed_mm_s = 1e-4;
  EXPECT_NEAR(slow.full_loads().torque_nmm / slow.torque_nmm(), 1, 1e-6);
  EXPECT_NEAR(slow.full_loads().thrust_n / slow.thrust_n(), 1, 1e-6);
  slow.radius_mm = std::nullopt;
  EXPECT_NEAR(slow.full_loads().thrust_n / slow.thrust_n(), 1, 1e-6);
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

TEST(Forms, TheToolsPolygonsHoldTheirCurvesVolume) {
  const double ball = 4.0 / 3 * M_PI * 29 * 29 * 29;
  EXPECT_NEAR(ball_profile(29, 0.05).volume_mm3() / ball, 1, 2e-8);
  // Head less cap and core, by cylinders.
  const double head = M_PI * (15 * 15 - 1.25 * 1.25) * 8 -
                      (M_PI * 15 * 15 * kExample.full_contact_mm() - cap_mm3(29, kExample.full_contact_mm()));
  const double sag = 29 - std::sqrt(29 * 29 - 1.25 * 1.25);
  const double core = M_PI * 1.25 * 1.25 * sag - cap_mm3(29, sag);
  EXPECT_NEAR(convex_profile(29, 15, 1.25, 8, 0.05).volume_mm3() / (head + core), 1, 1e-7);
}

}  // namespace
}  // namespace reamsim::verify
