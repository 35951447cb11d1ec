#include "render/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/base/error.h"

namespace reamsim {
namespace {

/// The share of the picture that the subject may fill; the rest is for text, legends and the scale bar.
constexpr double kUsableHeight = 0.84;
constexpr double kUsableWidth = 0.60;
/// Bone within this distance of the focus has to be in the picture: half a large glenoid and its rim.
constexpr double kGlenoidReach_mm = 20;

/// Turns so that the viewer stands in the direction `towards_viewer`, with `up` up.
Mat3 look(const Vec3& towards_viewer, const Vec3& up) {
  const Vec3 z = towards_viewer.normalized();
  const Vec3 x = up.cross(z).normalized();
  Mat3 eye_from_bone;
  eye_from_bone.row(0) = x.transpose();
  eye_from_bone.row(1) = z.cross(x).transpose();
  eye_from_bone.row(2) = z.transpose();
  return eye_from_bone;
}

/// The direction from which an oblique view looks: anterior where it is known, else to the right of the face.
Vec3 front_side(const Subject& subject) {
  return subject.anterior ? *subject.anterior : Vec3(subject.superior.cross(subject.outward));
}

struct Extent {
  Vec2 min = Vec2::Constant(std::numeric_limits<double>::max());
  Vec2 max = Vec2::Constant(std::numeric_limits<double>::lowest());

  void add(const Vec2& p) {
    min = min.cwiseMin(p);
    max = max.cwiseMax(p);
  }
};

/// Chooses scale and middle so that the points to be seen fit into the usable part of the picture.
void frame(Camera& camera, const Mat3& turn, const Subject& subject, bool whole_bone) {
  Extent extent;
  const auto add = [&](const Vec3& p) { extent.add((turn * (p - subject.focus_mm)).head<2>()); };
  add(subject.focus_mm);
  for (const Vec3& p : subject.bone_mm) {
    if (whole_bone || (p - subject.focus_mm).norm() < kGlenoidReach_mm) add(p);
  }
  for (const Vec3& p : subject.head_mm) add(p);
  const Vec2 size = (extent.max - extent.min).cwiseMax(5.0);
  const Vec2 middle = 0.5 * (extent.min + extent.max);
  camera.mm_per_px =
      std::max(size.x() / (kUsableWidth * camera.width_px), size.y() / (kUsableHeight * camera.height_px));
  camera.reach_mm = 2 * subject.reach_mm + 10;
  camera.eye_from_bone.linear() = turn;
  camera.eye_from_bone.translation() = -(turn * subject.focus_mm) - Vec3(middle.x(), middle.y(), 0);
}

/// The plane through the tool's axis that faces the viewer of the section best.
Eigen::Vector4d section_plane(const Subject& subject) {
  const Vec3 axis = subject.bone_from_tool.linear().col(2);
  // A tool that points at the viewer leaves no choice but to look along the face.
  const Vec3 front = front_side(subject);
  const Vec3 wanted = std::abs(front.dot(axis)) < 0.95 ? front : subject.outward;
  const Vec3 normal = (wanted - wanted.dot(axis) * axis).normalized();
  Eigen::Vector4d plane;
  plane << -normal, normal.dot(subject.bone_from_tool.translation());
  return plane;
}

double degrees(double angle) {
  return angle * std::numbers::pi / 180;
}

}  // namespace

Eigen::Matrix4d Camera::clip_from_bone() const {
  Eigen::Matrix4d clip_from_eye = Eigen::Matrix4d::Identity();
  clip_from_eye(0, 0) = 2 / (mm_per_px * width_px);
  clip_from_eye(1, 1) = 2 / (mm_per_px * height_px);
  clip_from_eye(2, 2) = -1 / reach_mm;
  return clip_from_eye * eye_from_bone.matrix();
}

Vec2 Camera::pixel(const Vec3& point_mm) const {
  const Vec3 eye = eye_from_bone * point_mm;
  return {0.5 * width_px + eye.x() / mm_per_px, 0.5 * height_px - eye.y() / mm_per_px};
}

const std::vector<std::string>& camera_names() {
  static const std::vector<std::string> names{"glenoid", "oblique", "section", "overview"};
  return names;
}

Camera make_camera(const std::string& name, const Subject& subject, int width_px, int height_px) {
  if (width_px < 1 || height_px < 1) {
    throw InputError({}, "render.width_px",
                     "a picture of " + std::to_string(width_px) + " x " + std::to_string(height_px) + " pixels",
                     "expected at least 1 x 1");
  }
  Camera camera;
  camera.name = name;
  camera.width_px = width_px;
  camera.height_px = height_px;
  const Vec3 front = front_side(subject);
  if (name == "glenoid") {
    camera.draws_tool = false;
    frame(camera, look(subject.outward, subject.superior), subject, false);
  } else if (name == "oblique" || name == "overview") {
    const Vec3 towards_viewer = 0.72 * subject.outward + 0.58 * front + 0.28 * subject.superior;
    frame(camera, look(towards_viewer, subject.superior), subject, name == "overview");
  } else if (name == "section") {
    camera.cut_plane = section_plane(subject);
    const Vec3 facing = -camera.cut_plane->head<3>();
    // A little from lateral, so that the reamed face shows behind its cut edge.
    const Vec3 towards_viewer = std::cos(degrees(16)) * facing + std::sin(degrees(16)) * subject.outward;
    frame(camera, look(towards_viewer, subject.superior), subject, false);
  } else {
    std::string known;
    for (const std::string& other : camera_names()) known += (known.empty() ? "" : ", ") + other;
    throw InputError({}, "render.cameras", "found '" + name + "'", "expected one of " + known);
  }
  return camera;
}

}  // namespace reamsim
