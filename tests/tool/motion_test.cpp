// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Motions against what can be worked out by hand: lines, great circles, integrals of the spin speed.
#include "sim/tool/motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "sim/base/error.h"

namespace reamsim {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kPi = std::numbers::pi;

KeyframeSettings keyframe(double time_s, const Vec3& position, const Vec3& axis, double rpm) {
  KeyframeSettings k;
  k.time_s = time_s;
  k.position_mm = position;
  k.axis = axis;
  k.spin_rpm = rpm;
  return k;
}

MotionSettings keyframes(std::vector<KeyframeSettings> frames, double rate_hz = 100) {
  MotionSettings settings;
  settings.keyframes = std::move(frames);
  settings.frame_rate_hz = rate_hz;
  return settings;
}

MotionSettings plunge(const PlungeSettings& p, double rate_hz = 1000) {
  MotionSettings settings;
  settings.plunge = p;
  settings.frame_rate_hz = rate_hz;
  return settings;
}

Motion build(const MotionSettings& settings) {
  Diagnostics report;
  return build_motion(settings, std::nullopt, report);
}

std::string error_of(const MotionSettings& settings) {
  try {
    build(settings);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

double degrees_between(const Quat& a, const Quat& b) {
  return a.angularDistance(b) * 180 / kPi;
}

TEST(Keyframes, AStraightLineIsWalkedEvenly) {
  const Motion m = build(keyframes({keyframe(0, {1, 2, 3}, {0, 0, 1}, 60), keyframe(2, {5, -2, 3}, {0, 0, 1}, 60)}));
  ASSERT_EQ(m.poses.size(), 201u) << "0 s to 2 s at 100 Hz, both ends";
  EXPECT_EQ(m.frame_s(), 0.01);
  for (std::size_t k = 0; k < m.poses.size(); ++k) {
    const double share = static_cast<double>(k) / 200;
    EXPECT_NEAR((m.poses[k].position_mm - Vec3(1 + 4 * share, 2 - 4 * share, 3)).norm(), 0, 1e-12) << k;
    EXPECT_NEAR(m.poses[k].spin_angle_rad, 2 * kPi * 2 * share, 1e-12) << "60 rpm is a turn a second";
  }
}

TEST(Keyframes, OrientationGoesAlongTheGreatCircle) {
  MotionSettings settings =
      keyframes({keyframe(0, Vec3::Zero(), {0, 0, 1}, 0), keyframe(1, Vec3::Zero(), {0, 1, 0}, 0)});
  const Motion m = build(settings);
  const Vec3 middle = m.poses[50].orientation * Vec3::UnitZ();
  EXPECT_NEAR((middle - Vec3(0, 1, 1).normalized()).norm(), 0, 1e-12);
  EXPECT_NEAR((m.poses[30].orientation * Vec3::UnitZ()).dot(Vec3::UnitZ()), std::cos(0.3 * kPi / 2), 1e-12);
  for (const ToolPose& pose : m.poses.all())
    EXPECT_NEAR((pose.orientation * Vec3::UnitX() - Vec3::UnitX()).norm(), 0, 1e-12)
        << "no twist about the tool's axis";
}

TEST(Keyframes, QuaternionsTakeTheShortWay) {
  KeyframeSettings a = keyframe(0, Vec3::Zero(), {0, 0, 1}, 0), b = keyframe(1, Vec3::Zero(), {0, 0, 1}, 0);
  a.axis.reset(), b.axis.reset();
  a.quaternion = Quat::Identity();
  const Quat turn(Eigen::AngleAxisd(0.8, Vec3(1, 2, 2).normalized()));
  b.quaternion = Quat(-turn.coeffs());
  const Motion m = build(keyframes({a, b}));
  EXPECT_NEAR(degrees_between(m.poses[50].orientation, Quat(Eigen::AngleAxisd(0.4, Vec3(1, 2, 2).normalized()))), 0,
              1e-6);
}

TEST(Keyframes, SpinAngleIsTheIntegralOfALinearSpeed) {
  const Motion m = build(keyframes({keyframe(0, Vec3::Zero(), {0, 0, 1}, 0), keyframe(1, Vec3::Zero(), {0, 0, 1}, 300),
                                    keyframe(3, Vec3::Zero(), {0, 0, 1}, -300)},
                                   128));
  for (std::size_t k = 0; k < m.poses.size(); ++k) {
    const double t = static_cast<double>(k) / 128;
    const double turns = t <= 1 ? 2.5 * t * t : 2.5 + 5 * (t - 1) - 2.5 * (t - 1) * (t - 1);
    EXPECT_NEAR(m.poses[k].spin_angle_rad, 2 * kPi * turns, 1e-10) << t;
    EXPECT_NEAR(m.poses[k].spin_rpm, t <= 1 ? 300 * t : 300 - 300 * (t - 1), 1e-9) << t;
  }
}

TEST(Keyframes, LastFrameIsAtOrJustAfterTheEnd) {
  const auto count = [](double end_s, double rate_hz) {
    return build(keyframes({keyframe(0, Vec3::Zero(), {0, 0, 1}, 0), keyframe(end_s, Vec3::UnitX(), {0, 0, 1}, 0)},
                           rate_hz))
        .poses.size();
  };
  EXPECT_EQ(count(1.0, 1000), 1001u);
  EXPECT_EQ(count(0.3, 1000), 301u) << "0.3 is not exact in binary";
  EXPECT_EQ(count(0.0999, 100), 11u);
  EXPECT_EQ(count(0.001, 100), 2u);
}

TEST(Keyframes, TheToolRestsUntilTheLastFrameEnds) {
  // 60 rpm, and 2.5 frames of motion.
  const Motion m =
      build(keyframes({keyframe(0, Vec3::Zero(), {0, 0, 1}, 60), keyframe(0.025, {5, 0, 0}, {0, 0, 1}, 60)}));
  ASSERT_EQ(m.poses.size(), 4u);
  EXPECT_NEAR(m.poses[2].position_mm.x(), 4, 1e-12);
  EXPECT_NEAR(m.poses[3].position_mm.x(), 5, 1e-12);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(m.poses[k].spin_angle_rad, 2 * kPi * 0.01 * double(k), 1e-12) << k;
}

TEST(Keyframes, FirstKeyframeIsTimeZero) {
  Diagnostics report;
  const Motion m = build_motion(keyframes({keyframe(5, {1, 0, 0}, {0, 0, 1}, 0), keyframe(6, {2, 0, 0}, {0, 0, 1}, 0)}),
                                std::nullopt, report);
  EXPECT_EQ(m.poses.size(), 101u);
  EXPECT_EQ(m.poses[0].position_mm, Vec3(1, 0, 0));
  EXPECT_THAT(report.notes, testing::ElementsAre(HasSubstr("5 s")));
}

TEST(Keyframes, AQuaternionWithoutLengthNamesTheKey) {
  KeyframeSettings none = keyframe(1, Vec3::Zero(), {0, 0, 1}, 0);
  none.axis.reset();
  none.quaternion = Quat(0, 0, 0, 0);
  EXPECT_THAT(error_of(keyframes({keyframe(0, Vec3::Zero(), {0, 0, 1}, 0), none})),
              HasSubstr("motion.keyframes[1].quaternion: the quaternion has length 0"));
  EXPECT_THAT(error_of({}), HasSubstr("plunge, push, keyframes or csv"));
}

TEST(Keyframes, AQuaternionThatIsNoUnitIsNormalisedWithAWarning) {
  KeyframeSettings a = keyframe(0, Vec3::Zero(), {0, 0, 1}, 0), b = keyframe(1, Vec3::Zero(), {0, 0, 1}, 0);
  b.axis.reset();
  b.quaternion = Quat(2, 0, 0, 0);
  Diagnostics report;
  const Motion m = build_motion(keyframes({a, b}), std::nullopt, report);
  EXPECT_NEAR(m.poses.back().orientation.norm(), 1, 1e-15);
  EXPECT_THAT(report.warnings, testing::ElementsAre(HasSubstr("length 2")));
}

TEST(Plunge, TimingAndDepth) {
  PlungeSettings p;
  p.entry_mm = {10, 20, 30};
  p.axis = {0, 0, -2};
  p.approach_mm = 2;
  p.feed_mm_s = 4;
  p.depth_mm = 6;
  p.dwell_s = 0.5;
  p.retract_mm = 10;
  p.retract_mm_s = 20;
  p.spin_rpm = 250;
  const Motion m = build(plunge(p));
  ASSERT_EQ(m.poses.size(), 3001u) << "2 s of feed, 0.5 s of dwell, 0.5 s of retraction";
  const auto z = [&](int ms) { return m.poses[static_cast<std::size_t>(ms)].position_mm.z(); };
  EXPECT_NEAR(z(0), 32, 1e-12) << "the approach begins above the entry";
  EXPECT_NEAR(z(500), 30, 1e-12) << "at the entry";
  EXPECT_NEAR(z(1250), 27, 1e-12);
  EXPECT_NEAR(z(2000), 24, 1e-12) << "at full depth";
  EXPECT_NEAR(z(2300), 24, 1e-12);
  EXPECT_NEAR(z(2500), 24, 1e-12);
  EXPECT_NEAR(z(2750), 29, 1e-12);
  EXPECT_NEAR(z(3000), 34, 1e-12);
  for (const ToolPose& pose : m.poses.all()) {
    EXPECT_NEAR(pose.orientation.angularDistance(Quat::Identity()), 0, 1e-12) << "+z of T against the way it goes";
    EXPECT_EQ(pose.spin_rpm, 250);
  }
  EXPECT_NEAR(m.poses.back().spin_angle_rad, 250.0 / 60 * 2 * kPi * 3, 1e-9);
}

TEST(Plunge, WithoutDwellOrRetraction) {
  PlungeSettings p;
  p.dwell_s = 0;
  p.retract_mm = 0;
  p.approach_mm = 0;
  p.depth_mm = 1;
  p.feed_mm_s = 1;
  const Motion m = build(plunge(p));
  EXPECT_EQ(m.poses.size(), 1001u);
  EXPECT_NEAR(m.poses.back().position_mm.z(), -1, 1e-12);
}

TEST(Plunge, PhasesTooShortToChangeTheTimeAreLeftOut) {
  for (const double tiny : {1e-308, 1e-20, 1e-16}) {
    PlungeSettings p;
    p.dwell_s = tiny;
    p.retract_mm = tiny;
    p.depth_mm = 1;
    const Motion m = build(plunge(p));
    for (const ToolPose& pose : m.poses.all()) {
      ASSERT_TRUE(pose.position_mm.allFinite() && pose.orientation.coeffs().allFinite()) << tiny;
      ASSERT_TRUE(std::isfinite(pose.spin_angle_rad) && std::isfinite(pose.spin_rpm)) << tiny;
    }
    EXPECT_NEAR(m.poses.back().position_mm.z(), -1, 1e-12) << tiny;
  }
}

TEST(Plunge, FasterThanTheFramesIsWarnedOf) {
  PlungeSettings p;
  p.approach_mm = 5;
  p.depth_mm = 5;
  p.feed_mm_s = 1000;
  p.dwell_s = 0;
  p.retract_mm = 20;
  p.retract_mm_s = 1000;
  MotionSettings fast = plunge(p);
  fast.frame_rate_hz = 10;
  Diagnostics report;
  const Motion m = build_motion(fast, std::nullopt, report);
  EXPECT_EQ(m.poses.size(), 2u) << "0.03 s of motion";
  EXPECT_NEAR(m.poses.back().position_mm.z(), 15, 1e-12);
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_NE(report.warnings[0].find("the pose at 0.01 s lies between two frames"), std::string::npos)
      << report.warnings[0];
  Diagnostics none;
  fast.frame_rate_hz = 1000;
  build_motion(fast, std::nullopt, none);
  EXPECT_TRUE(none.warnings.empty());
}

TEST(Plunge, ToolPointsAgainstAnyAxis) {
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(-1, 0.01, 0), Vec3(0, 1, 0), Vec3(0.611, -0.548, 0.572)}) {
    PlungeSettings p;
    p.axis = axis;
    const Motion m = build(plunge(p));
    const Mat3 r = m.poses[0].orientation.toRotationMatrix();
    EXPECT_NEAR((r.col(2) + axis.normalized()).norm(), 0, 1e-12);
    EXPECT_NEAR(r.determinant(), 1, 1e-12);
    EXPECT_EQ(m.poses[0].orientation.coeffs(), build(plunge(p)).poses[0].orientation.coeffs());
  }
}

TEST(Plunge, WithoutTravelNamesTheKeys) {
  PlungeSettings p;
  p.approach_mm = p.depth_mm = 0;
  EXPECT_THAT(error_of(plunge(p)), HasSubstr("motion.plunge.approach_mm + depth_mm"));
}

TEST(GlenoidFrameMotion, IsTakenToTheBoneFrame) {
  GlenoidFrame glenoid;
  glenoid.bone_from_glenoid.linear() = Eigen::AngleAxisd(kPi / 2, Vec3::UnitY()).toRotationMatrix();  // z of G = x of B
  glenoid.bone_from_glenoid.translation() = Vec3(100, 50, -20);
  PlungeSettings p;
  p.approach_mm = 3;
  MotionSettings settings = plunge(p);
  settings.frame = PoseFrame::glenoid;
  Diagnostics report;
  const Motion m = build_motion(settings, glenoid, report);
  EXPECT_NEAR((m.poses[0].position_mm - Vec3(103, 50, -20)).norm(), 0, 1e-12);
  EXPECT_NEAR((m.poses[0].orientation * Vec3::UnitZ() - Vec3::UnitX()).norm(), 0, 1e-12);
  const Rigid bone_from_tool = m.poses[0].bone_from_tool();
  EXPECT_NEAR((bone_from_tool * Vec3(0, 0, 2) - Vec3(105, 50, -20)).norm(), 0, 1e-12);
  EXPECT_THAT(error_of(settings), HasSubstr("motion.frame: frame is glenoid"));
}

TEST(MotionLimits, TenMillionFramesAtMost) {
  const auto settings = [](double end_s, double rate_hz) {
    return keyframes({keyframe(0, Vec3::Zero(), {0, 0, 1}, 0), keyframe(end_s, Vec3::UnitX(), {0, 0, 1}, 0)}, rate_hz);
  };
  EXPECT_THAT(error_of(settings(1e5, 1000)), HasSubstr("1e+08 frames; at most ten million"));
  EXPECT_THAT(error_of(settings(1e300, 1e300)), HasSubstr("ten million"));
}

TEST(Interpolate, MeetsBothEndsAndTheMiddle) {
  ToolPose a, b;
  a.position_mm = {1, 0, 0};
  b.position_mm = {3, 4, 0};
  b.orientation = Quat(Eigen::AngleAxisd(1.0, Vec3::UnitX()));
  a.spin_angle_rad = 2, b.spin_angle_rad = 4;
  a.spin_rpm = 100, b.spin_rpm = 200;
  const ToolPose middle = interpolate(a, b, 0.5);
  EXPECT_EQ(middle.position_mm, Vec3(2, 2, 0));
  EXPECT_NEAR(degrees_between(middle.orientation, Quat(Eigen::AngleAxisd(0.5, Vec3::UnitX()))), 0, 1e-6);
  EXPECT_EQ(middle.spin_angle_rad, 3);
  EXPECT_EQ(middle.spin_rpm, 150);
  EXPECT_EQ(interpolate(a, b, 0).position_mm, a.position_mm);
  EXPECT_EQ(interpolate(a, b, 1).position_mm, b.position_mm);
}

}  // namespace
}  // namespace reamsim
