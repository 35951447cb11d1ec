// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/gl/camera.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "sim/base/error.h"

namespace reamsim {
namespace {

/// The fraction of the picture that the target may fill, along each side.
constexpr double kUsable = 0.92;
/// Bone within this distance of the focus must be in the picture: half a large glenoid and its rim.
constexpr double kGlenoidRadius_mm = 20;
/// Least distance of a user's camera from its target, and least sine between its view direction and up.
constexpr double kMinView_mm = 0.1;
constexpr double kMinSine = 0.01;

/// The rotation of a camera that is seen from the target in the direction `towards_viewer`.
Mat3 view_rotation(const Vec3& towards_viewer, const Vec3& up) {
  const Vec3 z = towards_viewer.normalized(), x = up.cross(z).normalized();
  Mat3 eye_from_bone;
  eye_from_bone << x.transpose(), z.cross(x).transpose(), z.transpose();
  return eye_from_bone;
}

/// The side of the oblique view: anterior where it is known, else to the right of the face.
Vec3 front_side(const ViewTarget& target) {
  return target.anterior ? *target.anterior : Vec3(target.superior.cross(target.outward));
}

/// Chooses scale and centre so that the target fits into the usable part of the picture.
void frame_target(Camera& camera, const Mat3& eye_from_bone, const ViewTarget& target, bool whole_bone) {
  Eigen::AlignedBox2d extent;
  const auto add = [&](const Vec3& p) { extent.extend((eye_from_bone * (p - target.focus_mm)).head<2>()); };
  add(target.focus_mm);
  for (const Vec3& p : target.bone_mm) {
    if (whole_bone || (p - target.focus_mm).norm() < kGlenoidRadius_mm) add(p);
  }
  for (const Vec3& p : target.tool_head_mm) add(p);
  const Vec2 size = extent.sizes().cwiseMax(5.0);
  const Vec2 middle = 0.5 * (extent.min() + extent.max());
  camera.mm_per_px = std::max(size.x() / camera.width_px, size.y() / camera.height_px) / kUsable;
  camera.used_width = std::min(1.0, size.x() / (kUsable * camera.mm_per_px * camera.width_px));
  camera.depth_range_mm = 2 * target.radius_mm + 10;
  camera.eye_from_bone.linear() = eye_from_bone;
  camera.eye_from_bone.translation() = -(eye_from_bone * target.focus_mm) - Vec3(middle.x(), middle.y(), 0);
}

/// The plane through the tool axis that faces the viewer of the section best.
Eigen::Vector4d section_plane(const ViewTarget& target) {
  const Vec3 axis = target.bone_from_tool.linear().col(2);
  // If the tool axis points at the viewer, look along the face.
  const Vec3 front = front_side(target);
  const Vec3 wanted = std::abs(front.dot(axis)) < 0.95 ? front : target.outward;
  const Vec3 normal = (wanted - wanted.dot(axis) * axis).normalized();
  Eigen::Vector4d plane;
  plane << -normal, normal.dot(target.bone_from_tool.translation());
  return plane;
}

/// Clip-space depth before the division by w: slope·z + offset, with z in eye coordinates.
std::pair<double, double> depth_row(const Camera& camera) {
  if (!camera.eye_mm) return {-1 / camera.depth_range_mm, 0};
  constexpr double kMinNear = 0.002;  // of the eye's distance, where the eye is within the scene
  const double eye_mm = *camera.eye_mm;
  const double near = std::max(eye_mm - camera.depth_range_mm, kMinNear * eye_mm);
  const double far = eye_mm + camera.depth_range_mm;
  const double slope = -(far + near) / (eye_mm * (far - near));
  return {slope, far / eye_mm - slope * (eye_mm - far)};
}

/// Throws InputError for a size below one pixel.
Camera sized_camera(const std::string& name, int width_px, int height_px) {
  if (width_px < 1 || height_px < 1) {
    throw InputError({}, "render.width_px", fmt::format("a picture of {} x {} pixels", width_px, height_px),
                     "expected at least 1 x 1");
  }
  return {.name = name, .width_px = width_px, .height_px = height_px};
}

double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

}  // namespace

Eigen::Matrix4d Camera::clip_from_bone() const {
  Eigen::Matrix4d clip_from_eye = Eigen::Matrix4d::Identity();
  clip_from_eye(0, 0) = 2 / (mm_per_px * width_px);
  clip_from_eye(1, 1) = 2 / (mm_per_px * height_px);
  std::tie(clip_from_eye(2, 2), clip_from_eye(2, 3)) = depth_row(*this);
  if (eye_mm) clip_from_eye(3, 2) = -1 / *eye_mm;
  return clip_from_eye * eye_from_bone.matrix();
}

double Camera::clip_depth_per_mm() const {
  // d/dz of (slope·z + offset)/w is the result over w², with w = 1 − z/eye_mm.
  const auto [slope, offset] = depth_row(*this);
  return -(slope + (eye_mm ? offset / *eye_mm : 0));
}

Vec2 Camera::pixel(const Vec3& point_mm) const {
  const Vec3 eye = eye_from_bone * point_mm;
  const double shrink = depth_ratio(eye);
  return {0.5 * width_px + eye.x() / mm_per_px / shrink, 0.5 * height_px - eye.y() / mm_per_px / shrink};
}

Camera make_camera(CameraView view, const ViewTarget& target, int width_px, int height_px) {
  Camera camera = sized_camera(name_of(view), width_px, height_px);
  Vec3 towards_viewer = target.outward;
  if (view == CameraView::glenoid) {
    camera.shows_tool = false;
  } else if (view == CameraView::section) {
    camera.cut_plane = section_plane(target);
    const Vec3 normal = -camera.cut_plane->head<3>();
    // Turned slightly towards lateral so that the reamed face is visible behind the cut edge.
    towards_viewer = std::cos(radians(16)) * normal + std::sin(radians(16)) * target.outward;
  } else {
    towards_viewer = 0.72 * target.outward + 0.58 * front_side(target) + 0.28 * target.superior;
  }
  frame_target(camera, view_rotation(towards_viewer, target.superior), target, view == CameraView::overview);
  return camera;
}

Camera make_user_camera(const UserCamera& wanted, const ViewTarget& target, int width_px, int height_px) {
  Camera camera = sized_camera(wanted.name, width_px, height_px);
  const std::string key = "render.user_cameras (" + wanted.name + ")";
  Rigid bone_from_frame = Rigid::Identity();
  if (wanted.frame == PoseFrame::glenoid) {
    if (!target.bone_from_glenoid) {
      throw InputError({}, key, "frame is glenoid but the results have no glenoid frame", "use frame: bone");
    }
    bone_from_frame = *target.bone_from_glenoid;
  }
  const Vec3 position_mm = bone_from_frame * wanted.position_mm;
  const Vec3 target_mm = wanted.target_mm ? Vec3(bone_from_frame * *wanted.target_mm) : target.focus_mm;
  const Vec3 towards_viewer = position_mm - target_mm;
  const bool along_superior = std::abs(towards_viewer.normalized().dot(target.superior)) >= 0.99;
  const Vec3 up = wanted.up        ? Vec3(bone_from_frame.linear() * *wanted.up)
                  : along_superior ? target.outward
                                   : target.superior;
  if (towards_viewer.norm() < kMinView_mm || up.normalized().cross(towards_viewer.normalized()).norm() < kMinSine) {
    throw InputError({}, key, "the camera is at its target, or looks along up", "change position_mm, target_mm or up");
  }
  camera.eye_from_bone.linear() = view_rotation(towards_viewer, up);
  camera.eye_from_bone.translation() = -(camera.eye_from_bone.linear() * target_mm);
  camera.depth_range_mm = target.radius_mm + (target_mm - target.focus_mm).norm() + 10;
  if (wanted.projection == Projection::perspective) {
    camera.eye_mm = towards_viewer.norm();
    camera.mm_per_px = 2 * *camera.eye_mm * std::tan(radians(wanted.fov_deg) / 2) / height_px;
  } else {
    camera.mm_per_px = wanted.width_mm / width_px;
  }
  return camera;
}

Camera make_turntable_camera(const ViewTarget& target, double turn, int width_px, int height_px) {
  Camera camera{.name = "turntable", .width_px = width_px, .height_px = height_px};
  constexpr double kElevation_deg = 15;
  const Vec3& up = target.superior;
  double radius_mm = 5, low_mm = -5, high_mm = 5;
  for (const Vec3& p : target.bone_mm) {
    const Vec3 from_focus = p - target.focus_mm;
    if (from_focus.norm() > kGlenoidRadius_mm) continue;
    const double height_mm = from_focus.dot(up);
    radius_mm = std::max(radius_mm, (from_focus - height_mm * up).norm());
    low_mm = std::min(low_mm, height_mm);
    high_mm = std::max(high_mm, height_mm);
  }
  const double sine = std::sin(radians(kElevation_deg)), cosine = std::cos(radians(kElevation_deg));
  const double tall_mm = cosine * (high_mm - low_mm) + 2 * sine * radius_mm;
  const double angle = 2 * std::numbers::pi * turn;
  const Vec3 level = std::cos(angle) * target.outward + std::sin(angle) * up.cross(target.outward);
  camera.mm_per_px = std::max(2 * radius_mm / width_px, tall_mm / height_px) / kUsable;
  camera.depth_range_mm = 2 * target.radius_mm + 10;
  camera.eye_from_bone.linear() = view_rotation(cosine * level + sine * up, up);
  const Vec3 middle_mm = target.focus_mm + 0.5 * (low_mm + high_mm) * up;
  camera.eye_from_bone.translation() = -(camera.eye_from_bone.linear() * middle_mm);
  return camera;
}

}  // namespace reamsim
