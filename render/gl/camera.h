#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// What there is to look at, in B. The same for every picture of a run, so that the camera stands still.
struct ViewTarget {
  Vec3 focus_mm = Vec3::Zero();              ///< the middle of the glenoid, or of the reamed region
  Vec3 outward = Vec3::UnitZ();              ///< out of the face, towards the drill
  Vec3 superior = Vec3::UnitY();             ///< perpendicular to `outward`
  std::optional<Vec3> anterior;              ///< perpendicular to both; only where the side is known
  std::optional<Rigid> bone_from_glenoid;    ///< where the results name a glenoid
  bool anatomical = false;                   ///< `superior` is anatomy, not a guess
  std::vector<Vec3> bone_mm;                 ///< points of the unreamed surface
  std::vector<Vec3> tool_head_mm;                 ///< points of the tool's head at its deepest
  Rigid bone_from_tool = Rigid::Identity();  ///< the tool at its deepest
  double radius_mm = 0;                       ///< no part of bone or tool is ever farther from the focus
};

/// A view. Orthographic: every length parallel to the picture has the same scale, so the scale bar is right everywhere.
/// In perspective it is right in the plane z = 0 of the eye's coordinates.
struct Camera {
  std::string name;
  int width_px = 0;
  int height_px = 0;
  Rigid eye_from_bone = Rigid::Identity();  ///< x right, y up, z towards the viewer; the picture's middle is x = y = 0
  double mm_per_px = 1;
  double depth_range_mm = 1;                       ///< depth kept on either side of the picture's plane
  std::optional<double> eye_mm;              ///< perspective: the eye is at z = eye_mm; without it orthographic
  std::optional<Eigen::Vector4d> cut_plane;  ///< what has a negative value is cut away; unit normal
  bool shows_tool = true;                    ///< false: its outline only

  [[nodiscard]] Eigen::Matrix4d clip_from_bone() const;
  /// How much less z a point gets in clip space per mm towards the viewer, times its w.
  [[nodiscard]] double clip_depth_per_mm() const;
  /// Where a point of B falls: pixels from the picture's upper left corner, y down. The point is in front of the eye.
  [[nodiscard]] Vec2 pixel(const Vec3& point_mm) const;
};

/// glenoid: face on, superior up, only the tool's outline. oblique: from lateral, anterior and superior. section: cut
/// open through the tool's axis, seen from anterior. overview: the oblique view of the whole bone.
/// Throws InputError for a size below one pixel.
Camera make_camera(CameraView view, const ViewTarget& target, int width_px, int height_px);

/// The user's own camera. Throws InputError where it needs a glenoid frame and there is none, or looks along `up`.
Camera make_user_camera(const UserCamera& wanted, const ViewTarget& target, int width_px, int height_px);

/// A camera that goes round the superior axis, a little from above: `turn` 0 looks at the face, ¼ comes from the side
/// that superior × outward points to, 1 is at the face again. The scale is the same all round.
Camera make_turntable_camera(const ViewTarget& target, double turn, int width_px, int height_px);

}  // namespace reamsim
