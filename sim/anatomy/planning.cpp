// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/planning.h"

#include <algorithm>
#include <cmath>

#include "sim/anatomy/column_bone.h"
#include "sim/base/parallel.h"

namespace reamsim {

namespace {

constexpr const char* kNoScapularFrame = "the scapular frame is unknown: set bone.glenoid.landmarks";

void set_angles(Planning& out, const Vec3& axis, const JointLine& line, const BoneAxes& axes) {
  if (axes.scapula) {
    out.planned.value = face_angles(axis, *axes.scapula);
    if (line.native.value) out.native.value = face_angles(line.native.value->direction, *axes.scapula);
  } else {
    out.planned.reason = out.native.reason = kNoScapularFrame;
  }
  if (!line.native.value) out.native.reason = line.native.reason;
  const auto& known = axes.scapula ? axes.scapula : axes.glenoid;
  if (known && line.native.value) {
    out.corrected.value = face_angles(line.native.value->direction, *known) - face_angles(axis, *known);
  } else {
    out.corrected.reason =
        known ? "native face: " + line.native.reason : "neither a scapular nor a glenoid frame is defined";
  }
}

/// Where a line meets the articular surface, as the distance from `point` along `direction`; all in the frame of the
/// implant. nullopt where they do not meet.
std::optional<double> meets_articular(const ImplantSettings& implant, const Vec3& point, const Vec3& direction) {
  if (implant.backside_radius_mm == 0) {
    constexpr double kAlong = 1e-3;
    if (std::abs(direction.z()) < kAlong) return std::nullopt;
    return (implant.thickness_mm - point.z()) / direction.z();
  }
  const Vec3 from = point - Vec3(0, 0, implant.thickness_mm + implant.backside_radius_mm);
  const double middle = -from.dot(direction);
  const double squared = middle * middle - from.squaredNorm() + std::pow(implant.backside_radius_mm, 2);
  if (squared < 0) return std::nullopt;
  const double half = std::sqrt(squared);
  const auto height = [&](double along) { return point.z() + along * direction.z(); };
  return height(middle - half) < height(middle + half) ? middle - half : middle + half;
}

Measured<double> medialization(const Rigid& bone_from_implant, const ImplantSettings& implant, const JointLine& line,
                               const BoneAxes& axes) {
  const auto none = [](const std::string& reason) { return Measured<double>{.value = {}, .reason = reason}; };
  if (!axes.scapula || !axes.face_center_mm) return none("the Friedman axis is unknown: set bone.glenoid.landmarks");
  if (!line.native.value) return none("native face: " + line.native.reason);
  const Vec3& lateral = axes.scapula->lateral;
  const auto before = meeting_point(*line.native_face->surface, *axes.face_center_mm, lateral);
  if (!before) return none("the Friedman axis does not meet the surface through the face");
  const Rigid implant_from_bone = bone_from_implant.inverse();
  const auto lateral_mm = meets_articular(implant, implant_from_bone * *before, implant_from_bone.linear() * lateral);
  if (!lateral_mm) return none("the Friedman axis does not meet the implant");
  return {.value = -*lateral_mm, .reason = ""};
}

/// Lengths of vault bone along a column, mm.
struct VaultColumn {
  double before_mm = 0;
  double left_mm = 0;
};

VaultColumn vault_column(ColumnBone& bone, const SeatedImplant& implant, const FootprintColumn& at, double depth_mm) {
  const Column& column = implant.map.at(at.place);
  if (column.state == ColumnState::air) return {};
  const double bottom_mm = column.before_mm - depth_mm;
  // A column that was reamed through has no cover any more.
  const double cover = column.cover > 0 ? column.cover : 1;
  VaultColumn out;
  out.before_mm = bone.continuous_mm(at.place, column.before_mm, bottom_mm, cover, &Fractions::before);
  if (column.state == ColumnState::through) return out;
  const double left_mm = bone.continuous_mm(at.place, column.after_mm, bottom_mm, cover, &Fractions::after);
  out.left_mm = std::max(left_mm + std::min(implant.gap_mm(at), 0.0), 0.0);
  return out;
}

/// The vault behind the back of the implant on its axis: the mean of the columns around it, which lies between four.
std::optional<double> axis_depth(const ReamedBone& bone, const SeatedImplant& implant, const ImplantShape& shape,
                                 const MetricSettings& settings) {
  const ColumnPlace first = (-implant.map.corner_mm / implant.map.pitch_mm).array().floor().cast<int>();
  const double back_mm = shape.back_mm(Vec2::Zero()).value_or(0);
  ColumnBone lengths(bone, implant.map, settings.dense_g_cm3);
  double sum_mm = 0;
  int columns = 0;
  for (const ColumnPlace& step : {ColumnPlace(0, 0), ColumnPlace(1, 0), ColumnPlace(0, 1), ColumnPlace(1, 1)}) {
    const FootprintColumn column{.place = first + step, .back_mm = back_mm};
    if (!implant.map.contains(column.place) || implant.map.at(column.place).state == ColumnState::air) continue;
    sum_mm += vault_column(lengths, implant, column, settings.implant->vault_depth_mm).left_mm;
    ++columns;
  }
  return columns > 0 ? std::optional(sum_mm / columns) : std::nullopt;
}

Vault measure_vault(const ReamedBone& bone, const SeatedImplant& implant, const ImplantShape& shape,
                    const MetricSettings& settings) {
  const double depth_mm = settings.implant->vault_depth_mm;
  std::vector<VaultColumn> columns(implant.footprint.size());
  constexpr std::size_t kColumnsAtOnce = 512;
  parallel_ranges(columns.size(), kColumnsAtOnce, [&](std::size_t begin, std::size_t end) {
    ColumnBone lengths(bone, implant.map, settings.dense_g_cm3);
    for (std::size_t i = begin; i < end; ++i) {
      columns[i] = vault_column(lengths, implant, implant.footprint[i], depth_mm);
    }
  });
  Vault out;
  double area_mm2 = 0;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const double column_mm2 = implant.footprint[i].weight * implant.column_mm2();
    out.before_mm3 += column_mm2 * columns[i].before_mm;
    out.left_mm3 += column_mm2 * columns[i].left_mm;
    area_mm2 += column_mm2;
  }
  out.mean_depth_mm = out.left_mm3 / area_mm2;
  out.axis_depth_mm = axis_depth(bone, implant, shape, settings);
  return out;
}

}  // namespace

std::optional<Planning> measure_planning(const ReamedBone& bone, const Rigid& bone_from_tool, const JointLine& line,
                                         const BoneAxes& axes, const MetricSettings& settings) {
  const auto pose = implant_pose(*settings.implant, bone_from_tool, axes);
  if (!pose) return std::nullopt;
  const ImplantShape shape(*settings.implant);
  const auto implant = place_implant(bone, *pose, shape, *settings.implant);
  if (!implant) return std::nullopt;
  Planning out;
  out.bone_from_implant = implant->bone_from_implant;
  set_angles(out, pose->linear().col(2), line, axes);
  out.medialization_mm = medialization(out.bone_from_implant, *settings.implant, line, axes);
  out.seating = measure_seating(bone, *implant, *settings.implant, settings.dense_g_cm3);
  out.vault = measure_vault(bone, *implant, shape, settings);
  out.pegs = measure_pegs(bone, *implant, shape, *settings.implant);
  return out;
}

}  // namespace reamsim
