// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/anatomy/column_map.h"
#include "sim/anatomy/native_face.h"
#include "sim/anatomy/reamed_face.h"
#include "sim/base/geometry.h"

namespace reamsim {

/// Anatomical directions and points of a bone, as far as they are known.
struct BoneAxes {
  std::optional<ScapularAxes> scapula;
  std::optional<ScapularAxes> glenoid;   ///< of the glenoid frame, see axes_of()
  std::optional<Vec3> face_center_mm{};  ///< centre of the articular face, on the Friedman axis
  std::vector<Vec3> rim_mm{};            ///< of the articular face, in order; empty: unknown
  std::optional<Rigid> bone_from_glenoid{};
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

/// A measured value, or the reason why it is missing.
template <class Value>
struct Measured {
  std::optional<Value> value;
  std::string reason;  ///< only without a value
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

/// `map`: along the reamer's axis, of the region that lost bone; `face`: from find_face(map).
JointLine measure_joint_line(const ReamedBone& bone, const ColumnMap& map, const ReamedFace& face,
                             const BoneAxes& axes);

}  // namespace reamsim
