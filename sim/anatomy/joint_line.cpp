// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/joint_line.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace reamsim {

namespace {

constexpr const char* kNoRim =
    "the rim of the face is unknown: set bone.glenoid.rim_mm (glenoid and cup phantoms have their own)";

/// Largest residual of a native face, mm; one voxel where that is more. For a reamed face it is one voxel.
constexpr double kRoughest_mm = 0.5;

/// Why a surface has no axis; "" if it has one.
std::string fit_failure(const std::optional<FaceSurface>& surface, double roughest_mm) {
  if (!surface) return "the face is too small for a fit";
  if (surface->fitted_fraction < kMinFittedFraction) {
    return fmt::format("the face is not a single sphere or plane: only {:.0f} % of it lies on the best fit",
                       100 * surface->fitted_fraction);
  }
  if (surface->rms_mm > roughest_mm) {
    return fmt::format("the face is not a single sphere or plane: the best fit leaves a residual of {:.2f} mm",
                       surface->rms_mm);
  }
  return "";
}

Measured<FaceAxis> checked(const std::optional<FaceAxis>& axis) {
  if (!axis) {
    return {.value = {},
            .reason =
                "the sphere fitted to the face is too small: its radius does not exceed its distance from the centre "
                "of the face"};
  }
  if (!(axis->error_deg <= kMaxAxisError_deg)) {
    return {
        .value = {},
        .reason = fmt::format("the face is too small or too rough: the standard error of its axis is {:.1f} degrees",
                              axis->error_deg)};
  }
  return {.value = axis, .reason = ""};
}

Measured<FaceAxis> native_axis(const NativeFace& face, const std::optional<Vec3>& center_mm, double voxel_mm) {
  if (std::string reason = fit_failure(face.surface, std::max(kRoughest_mm, voxel_mm)); !reason.empty()) {
    return {.value = {}, .reason = reason};
  }
  // A face of unknown centre has the mean of its points.
  return checked(axis_through(*face.surface, center_mm.value_or(face.surface->plane.point_mm)));
}

Measured<FaceAxis> reamed_axis(const std::optional<FaceSurface>& surface, const Rigid& bone_from_tool,
                               double voxel_mm) {
  if (std::string reason = fit_failure(surface, voxel_mm); !reason.empty()) return {.value = {}, .reason = reason};
  const auto meets = meeting_point(*surface, bone_from_tool.translation(), bone_from_tool.linear().col(2));
  if (!meets) return {.value = {}, .reason = "the reamer's axis does not meet the surface through the reamed face"};
  return checked(axis_through(*surface, *meets));
}

/// Why a point does not lie on the reamed face; "" if most columns around it are reamed and few are reamed through. The
/// core of a cannulated reamer is narrower than this neighbourhood.
std::string location_failure(const ColumnMap& map, const Vec3& point_mm) {
  constexpr double kRadius_mm = 3;
  constexpr double kMinReamed = 0.5;
  constexpr double kMaxThrough = 0.1;
  const Vec3 center = map.bone_from_map.inverse() * point_mm;
  int all = 0;
  int reamed = 0;
  int through = 0;
  map.for_each([&](const ColumnPlace& place) {
    if ((map.center_mm(place) - center.head<2>()).norm() > kRadius_mm) return;
    ++all;
    reamed += map.at(place).state == ColumnState::reamed ? 1 : 0;
    through += map.at(place).state == ColumnState::through ? 1 : 0;
  });
  const double columns = std::numbers::pi * kRadius_mm * kRadius_mm / (map.pitch_mm * map.pitch_mm);
  if (through > kMaxThrough * columns) return "the bone is perforated where the Friedman axis meets it";
  if (all == 0 || reamed < kMinReamed * columns) return "the Friedman axis meets the bone outside the reamed face";
  return "";
}

Measured<double> medialization(const JointLine& line, const ColumnMap& map, const BoneAxes& axes) {
  const auto none = [](const std::string& reason) { return Measured<double>{.value = {}, .reason = reason}; };
  if (!axes.scapula || !axes.face_center_mm) return none("the Friedman axis is unknown: set bone.glenoid.landmarks");
  if (!line.native.value) return none("native face: " + line.native.reason);
  if (!line.reamed.value) return none("reamed face: " + line.reamed.reason);
  const Vec3& lateral = axes.scapula->lateral;
  const auto before = meeting_point(*line.native_face->surface, *axes.face_center_mm, lateral);
  const auto after = meeting_point(*line.reamed_surface, *axes.face_center_mm, lateral);
  if (!before || !after) return none("the Friedman axis does not meet the surface through the face");
  if (std::string reason = location_failure(map, *after); !reason.empty()) return none(reason);
  return {.value = (*before - *after).dot(lateral), .reason = ""};
}

}  // namespace

FaceAngles face_angles(const Vec3& direction, const ScapularAxes& axes) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  const double superior = std::clamp(direction.dot(axes.superior), -1.0, 1.0);
  return {.version_deg = kDegrees * std::atan2(-direction.dot(axes.anterior), direction.dot(axes.lateral)),
          .inclination_deg = kDegrees * std::asin(superior)};
}

JointLine measure_joint_line(const ReamedBone& bone, const ColumnMap& map, const ReamedFace& face,
                             const BoneAxes& axes) {
  JointLine out;
  const double voxel_mm = bone.voxmap.grid.voxel_mm;
  const Vec3 reamer = map.bone_from_map.linear().col(2);
  FacePoints points{.points_mm = {}, .point_mm2 = map.pitch_mm * map.pitch_mm, .voxel_mm = voxel_mm};
  constexpr std::size_t kMaxPoints = 3000;  // more do not improve the fit
  const std::size_t step = 1 + face.columns.size() / kMaxPoints;
  points.point_mm2 *= static_cast<double>(step);
  for (std::size_t i = 0; i < face.columns.size(); i += step) {
    points.points_mm.push_back(map.in_bone(face.columns[i], map.at(face.columns[i]).after_mm));
  }
  out.reamed_surface = fit_face(points, reamer);
  out.reamed = reamed_axis(out.reamed_surface, map.bone_from_map, voxel_mm);
  const Vec3 outward = axes.scapula ? axes.scapula->lateral : axes.glenoid ? axes.glenoid->lateral : reamer;
  if (const auto outline = FaceOutline::of(axes.rim_mm, outward)) {
    out.native_face = measure_native_face(bone, *outline);
    out.native = native_axis(*out.native_face, axes.face_center_mm, voxel_mm);
    if (out.native_face->area_mm2 > 0) {
      out.reamed_fraction.value = out.native_face->reamed_mm2 / out.native_face->area_mm2;
    } else {
      out.reamed_fraction.reason = "no bone lies within the rim of the face";
    }
  } else {
    out.native.reason = out.reamed_fraction.reason = kNoRim;
  }
  out.medialization_mm = medialization(out, map, axes);
  return out;
}

}  // namespace reamsim
