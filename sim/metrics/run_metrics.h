#pragma once

#include <optional>

#include "sim/bone/bone.h"
#include "sim/metrics/joint_line.h"
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

/// Which way the planes look that are fitted to the reamed columns, before and after. A plane through a part of a bowl
/// leans as that part does: this is no orientation of the face (see FaceOrientation).
struct PlaneOrientation {
  std::optional<FaceAngles> before;  ///< in the scapular frame, so only where it is known; likewise:
  std::optional<FaceAngles> after;
  std::optional<FaceAngles> change;  ///< after less before; in the glenoid frame where there is no scapular frame
  double turned_deg = 0;             ///< the angle between the planes
};

/// With less of it reamed a face has not been turned.
inline constexpr double kMinReamedFraction = 0.5;

/// Which way the face looks, by the axes of JointLine.
struct FaceOrientation {
  Measured<FaceAngles> native;  ///< in the scapular frame; likewise:
  Measured<FaceAngles> reamed;
  std::optional<FaceAngles> reamer;  ///< of the reamer's axis
  /// Native less reamed: positive where retroversion or superior tilt became less. In the glenoid frame where there is
  /// no scapular frame. Nothing where less than kMinReamedFraction of the face was reamed.
  Measured<FaceAngles> corrected;
  std::optional<double> turned_deg;  ///< the angle between both axes
  std::optional<PlaneOrientation> planes;
};

/// What reaming did to the bone.
struct BoneMetrics {
  RemovedVolume removed;
  // Nothing of what follows where no column of bone lost anything.
  std::optional<ReamedDepth> depth;
  std::optional<ReamedFace> face;
  std::optional<JointLine> joint_line;
  std::optional<FaceOrientation> orientation;
  std::optional<RemainingDenseBone> remaining_dense;
  std::optional<Perforation> perforation;
  std::optional<Seating> seating;  ///< only for an implant
};

RemovedVolume removed_volume(const ReamedBone& bone, double dense_g_cm3);

/// `bone_from_tool`: the tool where it was deepest; the metrics look along its −z.
BoneMetrics measure_bone(const ReamedBone& bone, const Rigid& bone_from_tool, const BoneAxes& axes,
                         const MetricSettings& settings);

/// Room round the reamed region on a depth map, mm.
inline constexpr double kDepthMapMargin_mm = 6;

/// The depth map: columns along −z of the glenoid frame, or of the tool where it was deepest when there is none.
ColumnMap depth_map(const ReamedBone& bone, const std::optional<GlenoidFrame>& glenoid, const Rigid& bone_from_tool);

}  // namespace reamsim
