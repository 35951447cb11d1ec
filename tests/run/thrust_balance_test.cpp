// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The balance of a hand (sim/run/balance.h) on bones that are functions.
#include "sim/run/balance.h"

#include <gtest/gtest.h>

#include <cmath>

namespace reamsim::thrust_balance_tests {
namespace {

ThrustBalance pushing(double thrust_n) {
  return {.thrust_n = thrust_n, .max_feed_mm_s = 5};
}

TEST(BalancedFeed, LinearBoneGivesThrustOverSlopeInOneTrialWhenTheSlopeIsKnown) {
  const BoneForce bone = [](double feed) { return 235 * feed; };
  const FeedRate first = balanced_feed(pushing(50), bone, 0);
  EXPECT_NEAR(first.mm_s, 50 / 235.0, 1e-9);
  EXPECT_NEAR(first.bone_n_s_mm, 235, 1e-6);
  const FeedRate second = balanced_feed(pushing(50), bone, first.bone_n_s_mm);
  EXPECT_NEAR(second.mm_s, 50 / 235.0, 1e-9);
  EXPECT_EQ(second.evaluations, 1);
  EXPECT_FALSE(second.limited);
}

TEST(BalancedFeed, AirAndSoftBoneLeaveTheLimit) {
  const FeedRate air = balanced_feed(
      pushing(50), [](double) { return 0.0; }, 0);
  EXPECT_EQ(air.mm_s, 5);
  EXPECT_TRUE(air.limited);
  FeedState state;
  EXPECT_EQ(add_thrust_energies(pushing(50), air, 1e-3, state), 0);
  const FeedRate soft = balanced_feed(
      pushing(50), [](double feed) { return 2 * feed; }, 2);
  EXPECT_EQ(soft.mm_s, 5);
  EXPECT_EQ(add_thrust_energies(pushing(50), soft, 1e-3, state), 10);
}

TEST(BalancedFeed, GapBeforeTheBoneIsBracketed) {
  // Contact within the frame: no force up to 3 mm/s.
  const FeedRate feed = balanced_feed(
      pushing(50), [](double v) { return v < 3 ? 0.0 : 400 * (v - 3); }, 0);
  EXPECT_NEAR(feed.mm_s, 3.125, 1e-6);
  EXPECT_FALSE(feed.limited);
}

TEST(BalancedFeed, JumpOfTheForceEndsAtIt) {
  const FeedRate feed = balanced_feed(
      pushing(50), [](double v) { return v < 2 ? 10.0 : 90.0; }, 0);
  EXPECT_NEAR(feed.mm_s, 2, 1e-5);
  EXPECT_LT(feed.evaluations, 60);
}

TEST(BalancedFeed, ForcesOtherThanLinearBalance) {
  for (const double power : {0.5, 0.7, 2.0}) {
    const FeedRate feed = balanced_feed(
        pushing(30), [&](double v) { return 40 * std::pow(v, power); }, 0);
    EXPECT_NEAR(40 * std::pow(feed.mm_s, power), 30, 1e-3) << power;
    EXPECT_LT(feed.evaluations, 20) << power;
  }
}

TEST(BalancedFeed, StandsWhereTheRestingToolIsHeld) {
  ThrustBalance held = pushing(10);
  held.standing_n = 13;
  const FeedRate still = balanced_feed(
      held, [](double) -> double { throw std::logic_error("not needed"); }, 100);
  EXPECT_EQ(still.mm_s, 0);
  held.thrust_n = 23;
  EXPECT_NEAR(balanced_feed(
                  held, [](double v) { return 13 + 100 * v; }, 0)
                  .mm_s,
              0.1, 1e-9);
}

TEST(BalancedFeed, DampingTakesItsPart) {
  ThrustBalance damped = pushing(50);
  damped.damping_n_s_mm = 15;
  EXPECT_NEAR(balanced_feed(
                  damped, [](double v) { return 235 * v; }, 0)
                  .mm_s,
              0.2, 1e-9);
}

TEST(BalancedFeed, MassOnALinearBoneFollowsTheExponentialAtEveryStep) {
  constexpr double kSlope = 0.725, kThrust = 2, kMass = 10, kTau = 1e-3 * kMass / kSlope;
  for (const double frame_s : {1e-4, 1e-3, 1e-2, 0.1}) {
    FeedState state;
    double travel = 0, time = 0;
    for (int i = 0; i < 5; ++i) {
      const ThrustBalance forces{.thrust_n = kThrust,
                                 .max_feed_mm_s = 100,
                                 .inertia_n_s_mm = 1e-3 * kMass / frame_s,
                                 .velocity_mm_s = state.velocity_mm_s};
      const FeedRate feed = balanced_feed(
          forces, [](double v) { return kSlope * v; }, state.bone_n_s_mm);
      add_thrust_energies(forces, feed, frame_s, state);
      state.velocity_mm_s = feed.end_mm_s;
      state.bone_n_s_mm = feed.bone_n_s_mm;
      travel += feed.mm_s * frame_s;
      time += frame_s;
      const double steady = kThrust / kSlope, decay = std::exp(-time / kTau);
      EXPECT_NEAR(feed.end_mm_s, steady * (1 - decay), 1e-4 * steady) << frame_s;
      EXPECT_NEAR(travel, steady * (time - kTau * (1 - decay)), 2e-4 * steady * time) << frame_s;
    }
    // The hand's work is the bone's, kinetic energy and what is lost within frames.
    EXPECT_GT(state.lost_mj, 0);
    EXPECT_NEAR(state.hand_mj, kThrust * travel, 1e-9);
    EXPECT_NEAR(state.kinetic_mj, 0.5e-3 * kMass * state.velocity_mm_s * state.velocity_mm_s, 1e-9);
  }
}

TEST(BalancedFeed, StiffBoneDoesNotMakeTheVelocityOscillate) {
  FeedState state;
  for (int i = 0; i < 50; ++i) {
    const ThrustBalance forces{.thrust_n = i < 25 ? 50.0 : 25.0,
                               .max_feed_mm_s = 5,
                               .inertia_n_s_mm = 1e-3 * 0.5 / 1e-3,
                               .velocity_mm_s = state.velocity_mm_s};
    const FeedRate feed = balanced_feed(
        forces, [](double v) { return 235 * v; }, state.bone_n_s_mm);
    state.velocity_mm_s = feed.end_mm_s;
    state.bone_n_s_mm = feed.bone_n_s_mm;
    if (i % 25 <= 1) continue;
    EXPECT_NEAR(feed.mm_s, forces.thrust_n / 235, 1e-5) << i;
    EXPECT_NEAR(feed.end_mm_s, feed.mm_s, 1e-5) << i;
  }
}

}  // namespace
}  // namespace reamsim::thrust_balance_tests
