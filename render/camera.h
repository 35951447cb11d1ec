#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/base/geometry.h"

namespace reamsim {

/// What there is to look at, in B. The same for every picture of a run, so that the camera stands still.
struct Subject {
  Vec3 focus_mm = Vec3::Zero();              ///< the middle of the glenoid, or of the reamed region
  Vec3 outward = Vec3::UnitZ();              ///< out of the face, towards the drill
  Vec3 superior = Vec3::UnitY();             ///< perpendicular to `outward`
  std::optional<Vec3> anterior;              ///< perpendicular to both; only where the side is known
  bool anatomical = false;                   ///< `superior` is anatomy, not a guess
  std::vector<Vec3> bone_mm;                 ///< points of the unreamed surface
  std::vector<Vec3> head_mm;                 ///< points of the tool's head at its deepest
  Rigid bone_from_tool = Rigid::Identity();  ///< the tool at its deepest
  double reach_mm = 0;                       ///< no part of bone or tool is ever farther from the focus
};

/// An orthographic view: every length parallel to the picture has the same scale, so the scale bar is right everywhere.
struct Camera {
  std::string name;
  int width_px = 0;
  int height_px = 0;
  Rigid eye_from_bone = Rigid::Identity();  ///< x right, y up, z towards the viewer; the picture's middle is x = y = 0
  double mm_per_px = 1;
  double reach_mm = 1;                       ///< depth kept on either side of the picture's plane
  std::optional<Eigen::Vector4d> cut_plane;  ///< what has a negative value is cut away; unit normal
  bool draws_tool = true;                    ///< false: its outline only

  [[nodiscard]] Eigen::Matrix4d clip_from_bone() const;
  /// Where a point of B falls: pixels from the picture's upper left corner, y down.
  [[nodiscard]] Vec2 pixel(const Vec3& point_mm) const;
};

/// The names that make_camera() knows: glenoid, oblique, section, overview.
const std::vector<std::string>& camera_names();

/// glenoid: face on, superior up, only the tool's outline. oblique: from lateral, anterior and superior. section: cut
/// open through the tool's axis, seen from anterior. overview: the oblique view of the whole bone.
/// Throws InputError for another name or a size below one pixel.
Camera make_camera(const std::string& name, const Subject& subject, int width_px, int height_px);

}  // namespace reamsim
