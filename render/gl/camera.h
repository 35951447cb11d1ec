// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// What the cameras of a run look at, in B. It is the same for every picture of a run, so that the cameras do not move.
struct ViewTarget {
  Vec3 focus_mm = Vec3::Zero();              ///< the middle of the glenoid, or of the reamed region
  Vec3 outward = Vec3::UnitZ();              ///< out of the face, towards the drive
  Vec3 superior = Vec3::UnitY();             ///< perpendicular to `outward`
  std::optional<Vec3> anterior;              ///< perpendicular to both; only where the side is known
  std::optional<Rigid> bone_from_glenoid;    ///< if the results have a glenoid
  bool anatomical = false;                   ///< `superior` is anatomical, not assumed
  std::vector<Vec3> bone_mm;                 ///< points of the unreamed surface
  std::vector<Vec3> tool_head_mm;            ///< points of the tool's head at its greatest depth
  Rigid bone_from_tool = Rigid::Identity();  ///< at the tool's greatest depth
  double radius_mm = 0;                      ///< bounds the distance of bone and tool from the focus
};

/// A tool of a run in a picture.
struct PlacedTool {
  Rigid bone_from_tool;  ///< with the spin where that is seen
  std::size_t pass = 0;  ///< index
};

/// A camera, orthographic or perspective; the scale of the latter holds in the plane z = 0 of eye coordinates.
struct Camera {
  std::string name;
  int width_px = 0;
  int height_px = 0;
  Rigid eye_from_bone = Rigid::Identity();  ///< x right, y up, z towards the viewer; x = y = 0 in the middle
  double mm_per_px = 1;
  double depth_range_mm = 1;                   ///< visible depth on either side of the picture plane
  std::optional<double> eye_mm{};              ///< perspective: the eye is at z = eye_mm; without it orthographic
  std::optional<Eigen::Vector4d> cut_plane{};  ///< points with a negative value are clipped; unit normal
  bool shows_tool = true;                      ///< false: only its outline
  double used_width = 1;  ///< fraction of the width, about the middle, that the target takes with its margin

  [[nodiscard]] Eigen::Matrix4d clip_from_bone() const;
  /// Decrease of clip-space z, times w, per mm towards the viewer.
  [[nodiscard]] double clip_depth_per_mm() const;
  /// Projection of a point of B in front of the eye: pixels from the upper left corner, y down.
  [[nodiscard]] Vec2 pixel(const Vec3& point_mm) const;
  // Of a point in eye coordinates: its distance from the eye over that of the picture plane, and the way to the viewer.
  [[nodiscard]] double depth_ratio(const Vec3& eye) const { return eye_mm ? 1 - eye.z() / *eye_mm : 1; }
  [[nodiscard]] Vec3 towards_viewer(const Vec3& eye) const {
    return eye_mm ? Vec3((Vec3(0, 0, *eye_mm) - eye).normalized()) : Vec3(Vec3::UnitZ());
  }
};

/// glenoid: en face, superior up, only the tool's outline. oblique: from lateral, anterior and superior. section: cut
/// along the tool axis, seen from anterior. overview: oblique, the whole bone.
Camera make_camera(CameraView view, const ViewTarget& target, int width_px, int height_px);

/// A camera defined by the user. Throws InputError when it needs a missing glenoid frame, or looks along `up`.
Camera make_user_camera(const UserCamera& wanted, const ViewTarget& target, int width_px, int height_px);

/// A camera on a circle about the superior axis, slightly elevated. `turn` 0 and 1 look at the face, ¼ from the side of
/// superior × outward. The scale is the same for all turns.
Camera make_turntable_camera(const ViewTarget& target, double turn, int width_px, int height_px);

/// A rectangle of a picture in pixels, y down; empty if width is 0.
struct Box {
  double x = 0, y = 0, width = 0, height = 0;
};

/// A picture: premultiplied BGRA (Cairo's ARGB32), top row first.
struct PixelImage {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint32_t> pixels;

  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_px) + static_cast<std::size_t>(x);
  }
  /// Whether each row has one colour, as a picture of the background alone.
  [[nodiscard]] bool has_plain_rows() const;
  /// Composites `part` over this picture with its upper left corner at (x, y), both at least 0, clipped.
  void paste(const PixelImage& part, int x, int y);
};

/// A picture of one colour, 0xRRGGBB.
PixelImage plain_image(int width_px, int height_px, std::uint32_t rgb);

/// The picture reduced by `factor` along each axis: each pixel is the mean of a square.
PixelImage downsampled(PixelImage image, int factor);

/// The picture with smoothed edges, cheaper than multisampling (T. Lottes, "FXAA", NVIDIA white paper, 2009): blends
/// each pixel at a brightness step with its neighbour across it; others stay identical. Transparency is white.
PixelImage antialiased(const PixelImage& image);

/// Writes a PNG: RGB if all is opaque, else RGBA; `software`, if any, near the file's beginning. Throws RunError.
void write_png(const std::string& path, const PixelImage& image, const std::string& software = "");

}  // namespace reamsim
