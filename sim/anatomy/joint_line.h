// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/anatomy/column_map.h"
#include "sim/anatomy/face_surface.h"
#include "sim/base/geometry.h"

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

/// Anatomical directions and points of a bone, as far as they are known.
struct BoneAxes {
  std::optional<ScapularAxes> scapula;
  std::optional<ScapularAxes> glenoid;   ///< of the glenoid frame, see axes_of()
  std::optional<Vec3> face_center_mm{};  ///< centre of the articular face, on the Friedman axis
  std::vector<Vec3> rim_mm{};            ///< of the articular face, in order; empty: unknown
  std::optional<Rigid> bone_from_glenoid{};

  /// The scapular frame, or else the glenoid frame.
  [[nodiscard]] const std::optional<ScapularAxes>& known() const { return scapula ? scapula : glenoid; }
};

/// Retroversion and superior tilt are positive.
struct FaceAngles {
  double version_deg = 0;
  double inclination_deg = 0;
};
inline FaceAngles operator-(const FaceAngles& a, const FaceAngles& b) {
  return {a.version_deg - b.version_deg, a.inclination_deg - b.inclination_deg};
}

/// Version and inclination of a unit vector out of a face: version = atan2(−n·anterior, n·lateral), inclination =
/// asin(n·superior). The convention of bone.phantom.version_deg and inclination_deg.
FaceAngles face_angles(const Vec3& direction, const ScapularAxes& axes);

/// Why a value is missing.
struct Missing {
  std::string reason;
};

/// A measured value, or the reason why it is missing.
template <class Value>
struct Measured {
  std::optional<Value> value;
  std::string reason;  ///< only without a value

  Measured() = default;
  Measured(const Value& found) : value(found) {}                    // not explicit on purpose
  Measured(Missing missing) : reason(std::move(missing.reason)) {}  // likewise
};

/// An axis with a larger standard error is rejected, degrees.
inline constexpr double kMaxAxisError_deg = 1;

/// The joint line and the orientation of the face before and after reaming.
///
/// Native axis: the line from the centre of the face to the centre of the fitted sphere (Lewis and Armstrong 2011, J
/// Shoulder Elbow Surg 20, 3–11), or the normal of the fitted plane. Reamed axis: the same from the intersection of the
/// reamer's axis and the reamed surface.
struct JointLine {
  std::optional<NativeFace> native_face;      ///< nullopt without a rim
  std::optional<FaceSurface> reamed_surface;  ///< fitted to the reamed face
  Measured<FaceAxis> native;
  Measured<FaceAxis> reamed;
  Measured<double> medialization_mm;  ///< along the Friedman axis, from the native to the reamed face
  Measured<double> reamed_fraction;   ///< of the native face's area
};

inline constexpr const char* kNoScapularFrame = "the scapular frame is unknown: set bone.glenoid.landmarks";

/// The angles of an axis in a frame; `without_frame`: the reason where there is no frame.
Measured<FaceAngles> angles_of(const Measured<FaceAxis>& axis, const std::optional<ScapularAxes>& frame,
                               const char* without_frame);

/// The intersection of the Friedman axis and the native face, B.
Measured<Vec3> point_on_native_face(const JointLine& line, const BoneAxes& axes);

/// `map`: along the reamer's axis, of the region that lost bone; `face`: from find_face(map).
JointLine measure_joint_line(const ReamedBone& bone, const ColumnMap& map, const ReamedFace& face,
                             const BoneAxes& axes);

}  // namespace reamsim
