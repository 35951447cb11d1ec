// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <vector>

#include "sim/anatomy/column_map.h"
#include "sim/anatomy/face_surface.h"

namespace reamsim {

/// The rim of an articular face, as a closed polygon in the plane through its points.
class FaceOutline {
 public:
  /// `rim_mm`: points of B in order around the face. `outward`: the side of the plane outside the bone. nullopt for
  /// points on a line.
  static std::optional<FaceOutline> of(const std::vector<Vec3>& rim_mm, const Vec3& outward);

  /// The frame of the plane: origin at the centroid of the polygon, +z out of the bone.
  [[nodiscard]] const Rigid& bone_from_outline() const { return bone_from_outline_; }
  /// Distance of a point of the plane from the polygon, mm; positive inside.
  [[nodiscard]] double inside_mm(const Vec2& place_mm) const;
  /// Bounding box of the points, in the frame of the plane.
  [[nodiscard]] const Aabb& box_mm() const { return box_mm_; }
  /// Radius of the largest circle around the centroid that lies inside.
  [[nodiscard]] double inner_radius_mm() const { return inside_mm(Vec2::Zero()); }

 private:
  Rigid bone_from_outline_ = Rigid::Identity();
  std::vector<Vec2> corners_mm_;
  Aabb box_mm_;
};

/// The articular face before reaming, inside its rim.
struct NativeFace {
  std::optional<FaceSurface> surface;  ///< fitted to the face, at a distance from its rim
  double area_mm2 = 0;                 ///< along the surface, not of its projection
  double reamed_mm2 = 0;               ///< the part that was reamed to at least about half a voxel
};

/// Lines of sight on a face are at least this far apart, mm.
inline constexpr double kFacePitch_mm = 0.5;
/// The fit excludes points nearer than this to the rim, because the rim is rounded and its points are picked by hand,
/// mm. It is at most a quarter of the face's inner radius.
inline constexpr double kRimMargin_mm = 2.5;

/// Measures the unreamed surface within the outline, along the normal of the outline's plane. Heights are integrals of
/// fill, as in ColumnMap. Areas use the slope of a plane through the heights within 1.5 mm.
NativeFace measure_native_face(const ReamedBone& bone, const FaceOutline& outline);

}  // namespace reamsim
