// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "render/gl/camera.h"
#include "sim/base/error.h"

namespace reamsim {
namespace {

constexpr int kUserWidth = 800;
constexpr int kUserHeight = 600;

/// A glenoid frame that lies askew in B, and a bone round it.
ViewTarget askew() {
  ViewTarget target;
  Rigid frame = Rigid::Identity();
  frame.linear() = (Eigen::AngleAxisd(0.7, Vec3::UnitZ()) * Eigen::AngleAxisd(-0.4, Vec3::UnitX())).toRotationMatrix();
  frame.translation() = Vec3(110, -35, 420);
  target.bone_from_glenoid = frame;
  target.focus_mm = frame.translation();
  target.outward = frame.linear().col(2);
  target.superior = frame.linear().col(1);
  target.anatomical = true;
  for (int i = 0; i < 200; ++i) {
    target.bone_mm.emplace_back(frame * Vec3(12 * std::cos(0.7 * i), 16 * std::sin(0.7 * i), -0.05 * i));
  }
  target.radius_mm = 90;
  return target;
}

UserCamera from_the_face() {
  UserCamera camera;
  camera.name = "face";
  camera.frame = PoseFrame::glenoid;
  camera.position_mm = Vec3(0, 0, 100);
  camera.target_mm = Vec3::Zero();
  camera.up = Vec3::UnitY();
  camera.fov_deg = 40;
  return camera;
}

Vec2 pixel_of(const Camera& camera, const ViewTarget& target, const Vec3& glenoid_mm) {
  return camera.pixel(*target.bone_from_glenoid * glenoid_mm);
}

TEST(UserCameraTest, PerspectiveIsThatOfAPinhole) {
  const ViewTarget target = askew();
  const Camera camera = make_user_camera(from_the_face(), target, kUserWidth, kUserHeight);
  // Focal length in pixels: half the picture's height over the tangent of half its angle.
  const double focal_px = 0.5 * kUserHeight / std::tan(20 * std::numbers::pi / 180);
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(10, -7, 0), Vec3(10, -7, 30), Vec3(-13, 4, -55), Vec3(20, 20, 80)}) {
    const Vec2 at = pixel_of(camera, target, p);
    EXPECT_NEAR(at.x(), 0.5 * kUserWidth + focal_px * p.x() / (100 - p.z()), 1e-9);
    EXPECT_NEAR(at.y(), 0.5 * kUserHeight - focal_px * p.y() / (100 - p.z()), 1e-9);
  }
}

TEST(UserCameraTest, InPerspectiveTheScaleHoldsAtTheTarget) {
  const ViewTarget target = askew();
  const Camera camera = make_user_camera(from_the_face(), target, kUserWidth, kUserHeight);
  const Vec2 moved = pixel_of(camera, target, Vec3(7, 0, 0)) - pixel_of(camera, target, Vec3(-3, 0, 0));
  EXPECT_NEAR(moved.x() * camera.mm_per_px, 10, 1e-9);
  const Vec2 nearer = pixel_of(camera, target, Vec3(7, 0, 20)) - pixel_of(camera, target, Vec3(-3, 0, 20));
  EXPECT_NEAR(nearer.x() * camera.mm_per_px, 12.5, 1e-9);
}

TEST(UserCameraTest, OrthographicHasItsWidthAtEveryDepth) {
  const ViewTarget target = askew();
  UserCamera wanted = from_the_face();
  wanted.projection = Projection::orthographic;
  wanted.width_mm = 64;
  const Camera camera = make_user_camera(wanted, target, kUserWidth, kUserHeight);
  for (const double z : {-40.0, 0.0, 60.0}) {
    EXPECT_NEAR(pixel_of(camera, target, Vec3(-32, 0, z)).x(), 0, 1e-9);
    EXPECT_NEAR(pixel_of(camera, target, Vec3(32, 0, z)).x(), kUserWidth, 1e-9);
    EXPECT_NEAR(pixel_of(camera, target, Vec3(0, 8, z)).y(), 0.5 * kUserHeight - 100, 1e-9);
  }
}

TEST(UserCameraTest, ClipSpaceAgreesWithPixelsAndKeepsTheOrderOfDepths) {
  const ViewTarget target = askew();
  UserCamera wanted = from_the_face();
  for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
    wanted.projection = projection;
    const Camera camera = make_user_camera(wanted, target, kUserWidth, kUserHeight);
    double before = 2;
    for (double z = -89; z < 89; z += 2) {
      const Vec3 p = *target.bone_from_glenoid * Vec3(5, -3, z);
      const Eigen::Vector4d clip = camera.clip_from_bone() * p.homogeneous();
      EXPECT_NEAR((clip.x() / clip.w() + 1) * 0.5 * kUserWidth, camera.pixel(p).x(), 1e-8);
      EXPECT_NEAR((1 - clip.y() / clip.w()) * 0.5 * kUserHeight, camera.pixel(p).y(), 1e-8);
      const double depth = clip.z() / clip.w();
      EXPECT_LT(depth, before);
      EXPECT_GT(depth, -1);
      EXPECT_LT(depth, 1);
      before = depth;
    }
  }
}

TEST(UserCameraTest, TheLiftOfAPointIsItsStepTowardsTheViewer) {
  const ViewTarget target = askew();
  UserCamera wanted = from_the_face();
  for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
    wanted.projection = projection;
    const Camera camera = make_user_camera(wanted, target, kUserWidth, kUserHeight);
    const auto depth = [&](double z) {
      const Eigen::Vector4d clip = camera.clip_from_bone() * (*target.bone_from_glenoid * Vec3(0, 0, z)).homogeneous();
      return Vec2(clip.z() / clip.w(), clip.w());
    };
    for (const double z : {-50.0, 0.0, 50.0}) {
      const double step = 1e-4;
      const double w = depth(z).y();
      EXPECT_NEAR((depth(z).x() - depth(z + step).x()) / step, camera.clip_depth_per_mm() / (w * w), 1e-6);
    }
  }
}

TEST(UserCameraTest, WithoutTargetAndUpTheGlenoidIsInTheMiddleAndSuperiorIsUp) {
  const ViewTarget target = askew();
  UserCamera wanted = from_the_face();
  wanted.position_mm = Vec3(60, 10, 70);
  wanted.target_mm.reset();
  wanted.up.reset();
  const Camera camera = make_user_camera(wanted, target, kUserWidth, kUserHeight);
  const Vec2 middle = pixel_of(camera, target, Vec3::Zero());
  EXPECT_NEAR(middle.x(), 0.5 * kUserWidth, 1e-9);
  EXPECT_NEAR(middle.y(), 0.5 * kUserHeight, 1e-9);
  const Vec2 above = pixel_of(camera, target, Vec3(0, 5, 0));
  EXPECT_NEAR(above.x(), middle.x(), 1e-9);
  EXPECT_LT(above.y(), middle.y() - 10);
  wanted.position_mm = Vec3(0, 80, 0);  // along superior, which then cannot be up
  EXPECT_TRUE(make_user_camera(wanted, target, kUserWidth, kUserHeight).eye_from_bone.matrix().allFinite());
}

TEST(UserCameraTest, ACameraThatCannotBeIsAnInputError) {
  ViewTarget target = askew();
  UserCamera wanted = from_the_face();
  wanted.target_mm.reset();
  wanted.up = Vec3(0, 0, -3);
  EXPECT_THROW(make_user_camera(wanted, target, kUserWidth, kUserHeight), InputError);
  wanted.up.reset();
  wanted.position_mm = Vec3::Zero();
  EXPECT_THROW(make_user_camera(wanted, target, kUserWidth, kUserHeight), InputError);
  EXPECT_THROW(make_user_camera(from_the_face(), target, 0, kUserHeight), InputError);
  target.bone_from_glenoid.reset();
  EXPECT_THROW(make_user_camera(from_the_face(), target, kUserWidth, kUserHeight), InputError);
}

TEST(TurntableCameraTest, GoesRoundTheSuperiorAxisAtOneScale) {
  const ViewTarget target = askew();
  const Camera first = make_turntable_camera(target, 0, kUserWidth, kUserHeight);
  const Vec3 side = target.superior.cross(target.outward);
  for (int i = 0; i < 24; ++i) {
    const double turn = i / 24.0;
    const Camera camera = make_turntable_camera(target, turn, kUserWidth, kUserHeight);
    EXPECT_DOUBLE_EQ(camera.mm_per_px, first.mm_per_px);
    const Vec2 low = camera.pixel(target.focus_mm);
    const Vec2 high = camera.pixel(target.focus_mm + 10 * target.superior);
    EXPECT_NEAR(high.x(), low.x(), 1e-9);
    EXPECT_LT(high.y(), low.y());
    EXPECT_NEAR(low.x(), 0.5 * kUserWidth, 1e-9) << "the axis stands still";
    const Vec3 towards_viewer = camera.eye_from_bone.linear().row(2);
    const double angle = 2 * std::numbers::pi * turn;
    EXPECT_NEAR(std::atan2(towards_viewer.dot(side), towards_viewer.dot(target.outward)),
                std::remainder(angle, 2 * std::numbers::pi), 1e-9);
    for (const Vec3& p : target.bone_mm) {
      const Vec2 at = camera.pixel(p);
      EXPECT_TRUE(at.x() > 0 && at.y() > 0 && at.x() < kUserWidth && at.y() < kUserHeight) << turn;
    }
  }
  const Camera last = make_turntable_camera(target, 1, kUserWidth, kUserHeight);
  EXPECT_TRUE(last.eye_from_bone.isApprox(first.eye_from_bone, 1e-12));
}

}  // namespace
}  // namespace reamsim
