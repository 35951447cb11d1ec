#pragma once

#include <optional>

#include "sim/bone/bone.h"
#include "sim/metrics/reamed_face.h"
#include "sim/metrics/seating.h"
#include "sim/metrics/under_face.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// Volume that went, mm³. What is less dense than MetricSettings::dense_g_cm3 is trabecular.
struct RemovedVolume {
  double total_mm3 = 0;
  double trabecular_mm3 = 0;
  double dense_mm3 = 0;  ///< subchondral and cortical
};

/// How far the bone's surface went back along the reamer's axis.
struct ReamedDepth {
  double max_mm = 0;
  double mean_mm = 0;
  double p95_mm = 0;    ///< 95 % of the reamed area is less deep
  double area_mm2 = 0;  ///< reamed, across the axis
};

/// Version and inclination of a direction out of a face, degrees; retroversion and superior tilt are positive.
struct FaceAngles {
  double version_deg = 0;
  double inclination_deg = 0;
};

/// Which way the face looks. Angles of the faces are those of the planes fitted to them.
struct FaceOrientation {
  std::optional<FaceAngles> before;  ///< in the scapular frame, so only where it is known; likewise:
  std::optional<FaceAngles> after;
  std::optional<FaceAngles> reamer;  ///< of the reamer's axis
  std::optional<FaceAngles> change;  ///< after less before; in the glenoid frame where there is no scapular frame
  double turned_deg = 0;             ///< the angle between the face before and after
};

/// What reaming did to the bone.
struct BoneMetrics {
  RemovedVolume removed;
  // Nothing of what follows where no column of bone lost anything.
  std::optional<ReamedDepth> depth;
  std::optional<ReamedFace> face;
  std::optional<FaceOrientation> orientation;
  std::optional<DenseBoneLeft> dense_left;
  std::optional<Perforation> perforation;
  std::optional<Seating> seating;  ///< only for an implant
};

/// A bone's own directions, as far as they are known.
struct BoneAxes {
  std::optional<ScapularAxes> scapula;
  std::optional<ScapularAxes> glenoid;  ///< of the glenoid frame, see axes_of()
};

RemovedVolume removed_volume(const ReamedBone& bone, double dense_g_cm3);

/// Version and inclination of a unit vector, in the convention of bone.phantom.version_deg and inclination_deg.
FaceAngles face_angles(const Vec3& direction, const ScapularAxes& axes);

/// `bone_from_tool`: the tool where it was deepest; the metrics look along its −z.
BoneMetrics measure_bone(const ReamedBone& bone, const Rigid& bone_from_tool, const BoneAxes& axes,
                         const MetricSettings& settings);

/// Room round the reamed region on a depth map, mm.
inline constexpr double kDepthMapMargin_mm = 6;

/// The depth map: columns along −z of the glenoid frame, or of the tool where it was deepest when there is none.
ColumnMap depth_map(const ReamedBone& bone, const std::optional<GlenoidFrame>& glenoid, const Rigid& bone_from_tool);

}  // namespace reamsim
