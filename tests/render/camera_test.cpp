// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/gl/camera.h"
#include "render/pictures/overlay.h"

#include <gtest/gtest.h>

#include <cmath>

namespace reamsim {
namespace {

/// A left shoulder in LPS: lateral +x, superior +z, so anterior is −y.
ViewTarget left_shoulder() {
  ViewTarget target;
  target.focus_mm = Vec3(10, 20, 30);
  target.outward = Vec3::UnitX();
  target.superior = Vec3::UnitZ();
  target.anterior = -Vec3::UnitY();
  target.anatomical = true;
  for (int i = 0; i < 100; ++i) {
    target.bone_mm.emplace_back(target.focus_mm + Vec3(-1 - i % 7, 13 * std::cos(0.7 * i), 17 * std::sin(0.7 * i)));
  }
  target.bone_mm.emplace_back(target.focus_mm + Vec3(-90, 0, -60));
  target.bone_from_tool.linear() << 0, 0, 1, 1, 0, 0, 0, 1, 0;  // +z of T is lateral
  target.bone_from_tool.translation() = target.focus_mm;
  target.tool_head_mm = {target.focus_mm + Vec3(8, 15, 0), target.focus_mm + Vec3(8, -15, 0)};
  target.radius_mm = 150;
  return target;
}

bool in_picture(const Camera& camera, const Vec3& p) {
  const Vec2 at = camera.pixel(p);
  return at.x() > 0 && at.y() > 0 && at.x() < camera.width_px && at.y() < camera.height_px;
}

TEST(CameraTest, FaceOnSuperiorIsUpAndAnteriorOfALeftShoulderIsLeft) {
  const ViewTarget target = left_shoulder();
  const Camera camera = make_camera(CameraView::glenoid, target, 1920, 1080);
  const Vec2 middle = camera.pixel(target.focus_mm);
  const Vec2 up = camera.pixel(target.focus_mm + 10 * target.superior);
  const Vec2 front = camera.pixel(target.focus_mm + 10 * *target.anterior);
  EXPECT_NEAR(up.x(), middle.x(), 1e-9);
  EXPECT_NEAR(middle.y() - up.y(), 10 / camera.mm_per_px, 1e-9);
  EXPECT_NEAR(middle.x() - front.x(), 10 / camera.mm_per_px, 1e-9);
  EXPECT_FALSE(camera.shows_tool);
}

TEST(CameraTest, TheScaleIsTheSameEverywhereInThePicture) {
  const ViewTarget target = left_shoulder();
  for (const CameraView view : {CameraView::glenoid, CameraView::oblique, CameraView::section, CameraView::overview}) {
    const Camera camera = make_camera(view, target, 1280, 720);
    const Mat3 bone_from_eye = camera.eye_from_bone.linear().transpose();
    for (const Vec3& start : {target.focus_mm, Vec3(target.focus_mm + Vec3(-30, 5, 8))}) {
      for (int axis = 0; axis < 2; ++axis) {
        const Vec2 moved = camera.pixel(start + 10 * bone_from_eye.col(axis)) - camera.pixel(start);
        EXPECT_NEAR(moved.norm() * camera.mm_per_px, 10, 1e-9) << name_of(view);
      }
    }
  }
}

TEST(CameraTest, TheGlenoidAndTheToolsHeadAreInThePicture) {
  const ViewTarget target = left_shoulder();
  for (const CameraView view : {CameraView::glenoid, CameraView::oblique, CameraView::section, CameraView::overview}) {
    for (const auto& [width, height] : {std::pair{1920, 1080}, {400, 900}, {4096, 16}}) {
      const Camera camera = make_camera(view, target, width, height);
      for (std::size_t i = 0; i + 1 < target.bone_mm.size(); ++i) EXPECT_TRUE(in_picture(camera, target.bone_mm[i]));
      for (const Vec3& p : target.tool_head_mm) EXPECT_TRUE(in_picture(camera, p));
      EXPECT_EQ(in_picture(camera, target.bone_mm.back()), view == CameraView::overview) << name_of(view);
    }
  }
}

TEST(CameraTest, TheSectionPlaneHoldsTheToolsAxisAndIsSeenFromAnterior) {
  const ViewTarget target = left_shoulder();
  const Camera camera = make_camera(CameraView::section, target, 800, 600);
  ASSERT_TRUE(camera.cut_plane);
  const auto side = [&](const Vec3& p) { return camera.cut_plane->head<3>().dot(p) + (*camera.cut_plane)(3); };
  EXPECT_NEAR(side(target.focus_mm), 0, 1e-9);
  EXPECT_NEAR(side(target.focus_mm + 40 * target.bone_from_tool.linear().col(2)), 0, 1e-9);
  EXPECT_LT(side(target.focus_mm + *target.anterior), -0.99);
  EXPECT_GT(camera.eye_from_bone.linear().row(2).dot(*target.anterior), 0.9);
}

TEST(CameraTest, AToolThatPointsAtTheViewerStillHasASection) {
  ViewTarget target = left_shoulder();
  target.bone_from_tool.linear() = smallest_rotation(Vec3::UnitZ(), *target.anterior).matrix();
  const Camera camera = make_camera(CameraView::section, target, 800, 600);
  EXPECT_TRUE(camera.cut_plane->allFinite());
  EXPECT_NEAR(camera.cut_plane->head<3>().dot(*target.anterior), 0, 1e-9);
  EXPECT_TRUE(camera.eye_from_bone.matrix().allFinite());
}

TEST(CameraTest, ClipSpaceAndPixelsAgree) {
  const ViewTarget target = left_shoulder();
  const Camera camera = make_camera(CameraView::oblique, target, 640, 480);
  const Vec3 p = target.focus_mm + Vec3(3, -4, 5);
  const Eigen::Vector4d clip = camera.clip_from_bone() * p.homogeneous();
  EXPECT_NEAR((clip.x() + 1) * 320, camera.pixel(p).x(), 1e-9);
  EXPECT_NEAR((1 - clip.y()) * 240, camera.pixel(p).y(), 1e-9);
  EXPECT_LT(std::abs(clip.z()), 1);
}

TEST(CameraTest, AnEmptySizeIsAnInputError) {
  EXPECT_THROW(make_camera(CameraView::glenoid, left_shoulder(), 0, 10), InputError);
}

TEST(ScaleTest, TicksAreRoundNumbers) {
  EXPECT_DOUBLE_EQ(round_down(17), 10);
  EXPECT_DOUBLE_EQ(round_down(20), 20);
  EXPECT_DOUBLE_EQ(round_down(0.7), 0.5);
  EXPECT_DOUBLE_EQ(round_up(0.11), 0.2);
  EXPECT_DOUBLE_EQ(round_up(6), 10);
  const Scale scale = scale_up_to(3.02);
  EXPECT_DOUBLE_EQ(scale.max, 3.5);
  EXPECT_EQ(scale.ticks(), 8);
  EXPECT_EQ(scale.label(3), "1.5");
  EXPECT_EQ(scale_up_to(14).label(1), "2");
  EXPECT_DOUBLE_EQ(scale_up_to(0).max, 1);
  EXPECT_DOUBLE_EQ(scale_exactly(4.3).max, 4.3);
  for (double max = 0.013; max < 900; max *= 1.37) {
    const Scale any = scale_up_to(max);
    EXPECT_GE(any.max, max * (1 - 1e-9));
    EXPECT_GE(any.ticks(), 5) << max;
    EXPECT_LE(any.ticks(), 9) << max;
  }
}

}  // namespace
}  // namespace reamsim
