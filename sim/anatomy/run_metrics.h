// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>

#include "sim/anatomy/face_surface.h"
#include "sim/anatomy/joint_line.h"
#include "sim/anatomy/planning.h"
#include "sim/bone/bone.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// Thickness of the dense bone under the reamed face, along the normal of the face, until the density falls below the
/// threshold. Less than about half a voxel counts as none.
struct RemainingDenseBone {
  double mean_mm = 0;
  double least_mm = 0;
  double p05_mm = 0;           ///< 5 % of the face have less
  double exposed_percent = 0;  ///< of the face without dense bone
};
/// nullopt where the face has no columns. `dense_g_cm3`: the least density of dense bone.
std::optional<RemainingDenseBone> remaining_dense_bone(const ReamedBone& bone, const ColumnMap& map,
                                                       const ReamedFace& face, double dense_g_cm3);

/// Reaming through the bone, as areas projected along z of the map.
struct Perforation {
  int holes = 0;
  double area_mm2 = 0;  ///< of the holes: reamed through, surrounded by bone
  /// Reamed through within kFaceEdgeVoxels of the edge of the bone, or connected to it. The bone has an edge to air,
  /// and where the surface beside it lies below all removed bone.
  double rim_area_mm2 = 0;
};
Perforation find_perforation(const ColumnMap& map, double voxel_mm);

/// Removed volume, mm³. Bone below MetricSettings::dense_g_cm3 is trabecular.
struct RemovedVolume {
  double total_mm3 = 0;
  double trabecular_mm3 = 0;
  double dense_mm3 = 0;  ///< subchondral and cortical
};

/// Depth along the reamer's axis (docs/results.md, Headline).
struct AxialDepth {
  double max_mm = 0;
  double mean_mm = 0;
  double p95_mm = 0;    ///< 95 % of the reamed area is less deep
  double area_mm2 = 0;  ///< reamed area, projected along the axis
};

/// Orientation of the planes fitted to the reamed columns, before and after. A plane through a part of a bowl tilts
/// with that part: it does not show the orientation of the face (see FaceOrientation).
struct PlaneOrientation {
  std::optional<FaceAngles> before;  ///< in the scapular frame
  std::optional<FaceAngles> after;   ///< likewise
  std::optional<FaceAngles> change;  ///< after − before; in the glenoid frame if there is no scapular frame
  double turned_deg = 0;             ///< the angle between the planes
};

/// Reaming a smaller fraction of a face does not change its orientation.
inline constexpr double kMinReamedFraction = 0.5;

/// Orientation of the face, by the axes of JointLine.
struct FaceOrientation {
  Measured<FaceAngles> native;       ///< in the scapular frame
  Measured<FaceAngles> reamed;       ///< likewise
  std::optional<FaceAngles> reamer;  ///< of the reamer's axis, likewise
  /// Native − reamed: positive where retroversion or superior tilt decreased. In the glenoid frame if there is no
  /// scapular frame. Missing where less than kMinReamedFraction of the face was reamed.
  Measured<FaceAngles> corrected;
  std::optional<double> turned_deg;  ///< the angle between both axes
  std::optional<PlaneOrientation> planes;
};

/// Measurements of the reamed bone.
struct BoneMetrics {
  RemovedVolume removed;
  // The following are missing if no column lost bone.
  std::optional<AxialDepth> depth;
  std::optional<ReamedFace> face;
  std::optional<JointLine> joint_line;
  std::optional<FaceOrientation> orientation;
  std::optional<RemainingDenseBone> remaining_dense;
  std::optional<Perforation> perforation;
  std::optional<Planning> planning;  ///< only with an implant
};

RemovedVolume removed_volume(const ReamedBone& bone, double dense_g_cm3);

/// `bone_from_tool`: the deepest pose of the tool; depths are measured along its −z.
BoneMetrics measure_bone(const ReamedBone& bone, const Rigid& bone_from_tool, const BoneAxes& axes,
                         const MetricSettings& settings);

/// Margin around the reamed region on a depth map, mm.
inline constexpr double kDepthMapMargin_mm = 6;

/// The depth map: columns along −z of the glenoid frame, or else of the deepest pose of the tool.
ColumnMap depth_map(const ReamedBone& bone, const std::optional<GlenoidFrame>& glenoid, const Rigid& bone_from_tool);

}  // namespace reamsim
