#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/metrics/column_map.h"
#include "sim/metrics/native_face.h"
#include "sim/metrics/reamed_face.h"

namespace reamsim {

/// A bone's own directions and places, as far as they are known.
struct BoneAxes {
  std::optional<ScapularAxes> scapula;
  std::optional<ScapularAxes> glenoid;   ///< of the glenoid frame, see axes_of()
  std::optional<Vec3> face_center_mm{};  ///< centre of the joint face: the Friedman axis passes through it
  std::vector<Vec3> rim_mm{};            ///< of the joint face, in order round it; empty: not known
};

/// Version and inclination of a direction out of a face, degrees; retroversion and superior tilt are positive.
struct FaceAngles {
  double version_deg = 0;
  double inclination_deg = 0;
};

/// Version and inclination of a unit vector, in the convention of bone.phantom.version_deg and inclination_deg:
/// version = atan2(−n·anterior, n·lateral), inclination = asin(n·superior).
FaceAngles face_angles(const Vec3& direction, const ScapularAxes& axes);

/// A measured value, or why there is none.
template <class Value>
struct Measured {
  std::optional<Value> value;
  std::string reason;  ///< without a value
};

/// An axis whose standard error is above this says nothing, degrees.
inline constexpr double kMaxAxisError_deg = 1;

/// Where the joint line was and is, and which way the face looks.
///
/// Native: the line from the face's centre to the centre of the sphere through it (Lewis and Armstrong 2011, J Shoulder
/// Elbow Surg 20, 3–11), or the normal of the plane. Reamed: the line from where the reamer's axis meets the reamed
/// surface to the centre of the sphere through it, or the normal of the plane.
struct JointLine {
  std::optional<NativeFace> native_face;      ///< inside the rim, where there is one
  std::optional<FaceSurface> reamed_surface;  ///< fitted to the reamed face
  Measured<FaceAxis> native;
  Measured<FaceAxis> reamed;
  Measured<double> medialization_mm;  ///< along the Friedman axis, from the native to the reamed face
  Measured<double> reamed_fraction;   ///< of the native face's area
};

/// `map`: along the reamer's axis, of the region that lost bone; `face`: what find_face() makes of it.
JointLine measure_joint_line(const ReamedBone& bone, const ColumnMap& map, const ReamedFace& face,
                             const BoneAxes& axes);

}  // namespace reamsim
