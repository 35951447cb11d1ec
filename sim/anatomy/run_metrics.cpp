// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/run_metrics.h"

#include <fmt/core.h>

#include "sim/base/statistics.h"

namespace reamsim {

namespace {

constexpr double kStepVoxels = 0.5;
constexpr double kFaceBandVoxels = 1.5;  // uncertainty of the face
constexpr double kHalfFraction = 0.5;
constexpr double kNoBone = 1e-6;
constexpr double kMinReamedFraction = 0.5;  // reaming less of a face does not change its orientation
constexpr double kDepthMapMargin_mm = 6;    // around the reamed region
constexpr double kStepDownVoxels = 1;       // uncertainty of heights beside a wall

/// Length of dense bone below `face`, mm: the integral of its fraction, which includes partly filled voxels.
double dense_length(BoneFractions& fractions, const Vec3& face, const Vec3& inward, double voxel_mm, double most_mm) {
  const double step_mm = kStepVoxels * voxel_mm;
  const double band_mm = kFaceBandVoxels * voxel_mm;
  double length_mm = 0;
  bool inside = false;
  for (double along_mm = -band_mm; along_mm < most_mm; along_mm += step_mm) {
    const double fraction = fractions.at(face + along_mm * inward).dense;
    inside |= fraction >= kHalfFraction;
    if (!inside && along_mm > band_mm) return 0;
    if (!inside && fraction < kNoBone) length_mm = 0;
    length_mm += fraction * step_mm;
    if (inside && fraction < kHalfFraction) {
      // Beyond the lower end, interpolation spreads the fraction over two voxels.
      for (double tail_mm = along_mm + step_mm; tail_mm < along_mm + 2 * voxel_mm; tail_mm += step_mm) {
        const double rest = fractions.at(face + tail_mm * inward).dense;
        if (rest >= kHalfFraction || rest < kNoBone) break;
        length_mm += rest * step_mm;
      }
      return length_mm;
    }
  }
  return inside ? length_mm : 0;
}

/// Whether the bone ends within `reach` columns of one that was reamed through: in air, or at a step down to unreamed
/// bone whose surface lies below all bone that the column lost.
bool is_at_edge(const ColumnMap& map, const ColumnPlace& place, int reach, double voxel_mm) {
  const double limit_mm = map.at(place).after_mm - kStepDownVoxels * voxel_mm;
  return any_nearby(map, place, reach, [&](const ColumnPlace& other) {
    const Column& beside = map.at(other);
    return beside.state == ColumnState::air || (beside.state == ColumnState::bone && beside.before_mm < limit_mm);
  });
}

std::optional<AxialDepth> measure_depth(const ColumnMap& map) {
  std::vector<double> depths;
  for (const Column& column : map.columns) {
    const bool reamed = column.state == ColumnState::reamed || column.state == ColumnState::through;
    if (reamed) depths.push_back(column.depth_mm);
  }
  if (depths.empty()) return std::nullopt;
  return AxialDepth{.max_mm = *std::max_element(depths.begin(), depths.end()),
                    .mean_mm = mean(depths),
                    .p95_mm = quantile(depths, 0.95),
                    .area_mm2 = static_cast<double>(depths.size()) * map.pitch_mm * map.pitch_mm};
}

std::optional<PlaneOrientation> orientation_of_planes(const ReamedFace& face, const BoneAxes& axes) {
  if (!face.plane || !face.plane_before) return std::nullopt;
  const Vec3& before = face.plane_before->normal;
  const Vec3& after = face.plane->normal;
  PlaneOrientation out;
  if (axes.scapula) {
    out.before = face_angles(before, *axes.scapula);
    out.after = face_angles(after, *axes.scapula);
  }
  if (const auto& known = axes.known()) out.change = face_angles(after, *known) - face_angles(before, *known);
  out.turned_deg = angle_deg(before, after);
  return out;
}

FaceOrientation measure_orientation(const JointLine& line, const ReamedFace& face, const Vec3& reamer,
                                    const BoneAxes& axes) {
  FaceOrientation out;
  out.native = angles_of(line.native, axes.scapula, kNoScapularFrame);
  out.reamed = angles_of(line.reamed, axes.scapula, kNoScapularFrame);
  if (axes.scapula) out.reamer = face_angles(reamer, *axes.scapula);
  const auto& known = axes.known();
  const auto native = angles_of(line.native, known, "neither a scapular nor a glenoid frame is defined");
  const auto reamed = angles_of(line.reamed, known, "");
  const double fraction = line.reamed_fraction.value.value_or(0);
  if (native.value && reamed.value && fraction < kMinReamedFraction) {
    out.corrected.reason =
        fmt::format("only {:.0f} % of the face was reamed: the rest keeps its orientation", 100 * fraction);
  } else if (native.value && reamed.value) {
    out.corrected.value = *native.value - *reamed.value;
    out.turned_deg = angle_deg(line.native.value->direction, line.reamed.value->direction);
  } else {
    out.corrected.reason = native.value ? "reamed face: " + reamed.reason : "native face: " + native.reason;
  }
  out.planes = orientation_of_planes(face, axes);
  return out;
}

Perforation find_perforation(const ColumnMap& map, double voxel_mm) {
  const int edge = face_edge_columns(map, voxel_mm);
  Perforation out;
  for (const ColumnGroup& group : group_columns(map, ColumnState::through)) {
    const double area_mm2 = static_cast<double>(group.columns.size()) * map.pitch_mm * map.pitch_mm;
    const auto at_edge = [&](const ColumnPlace& place) { return is_at_edge(map, place, edge, voxel_mm); };
    if (group.reaches_air || std::ranges::any_of(group.columns, at_edge)) {
      out.rim_area_mm2 += area_mm2;
    } else {
      out.area_mm2 += area_mm2;
      ++out.holes;
    }
  }
  return out;
}

}  // namespace

std::optional<RemainingDenseBone> remaining_dense_bone(const BoneView& bone, const ColumnMap& map,
                                                       const ReamedFace& face, double dense_g_cm3) {
  if (!face.plane) return std::nullopt;
  const VoxelGrid& grid = bone.voxmap.grid;
  const double most_mm = grid.voxel_mm * grid.dims.cast<double>().norm();
  BoneFractions fractions(bone, dense_g_cm3);
  std::vector<double> lengths;
  lengths.reserve(face.columns.size());
  for (const ColumnPlace& place : face.columns) {
    const Vec3 point = map.in_bone(place, map.at(place).after_mm);
    lengths.push_back(dense_length(fractions, point, face.inward(point), grid.voxel_mm, most_mm));
  }
  const auto bare = std::count(lengths.begin(), lengths.end(), 0.0);
  return RemainingDenseBone{.mean_mm = mean(lengths),
                            .least_mm = *std::min_element(lengths.begin(), lengths.end()),
                            .p05_mm = quantile(lengths, 0.05),
                            .exposed_percent = 100 * static_cast<double>(bare) / static_cast<double>(lengths.size())};
}

RemovedVolume removed_volume(const BoneView& bone, double dense_g_cm3) {
  const int dense_grade = least_dense_grade(dense_g_cm3);
  std::int64_t trabecular = 0;  // in 1/65535 of a voxel: integers, so that the order of summation does not matter
  std::int64_t dense = 0;
  for_each_cut_voxel(bone, [&](const Vec3i&, std::uint8_t grade, std::uint16_t before, std::uint16_t after) {
    (grade >= dense_grade ? dense : trabecular) += before - after;
  });
  const double unit_mm3 = bone.voxmap.grid.voxel_mm3() / FillBricks::kWhole;
  return {.total_mm3 = static_cast<double>(trabecular + dense) * unit_mm3,
          .trabecular_mm3 = static_cast<double>(trabecular) * unit_mm3,
          .dense_mm3 = static_cast<double>(dense) * unit_mm3};
}

BoneMetrics measure_bone(const BoneView& bone, const Rigid& bone_from_tool, const BoneAxes& axes,
                         const MetricSettings& settings, const TriangleMesh* implant_mesh) {
  BoneMetrics out;
  const double voxel_mm = bone.voxmap.grid.voxel_mm;
  out.removed = removed_volume(bone, settings.dense_g_cm3);
  out.versions = measure_versions(Missing{"no bone was removed"}, axes);
  const ColumnMap map = map_columns(bone, bone_from_tool, {.margin_mm = voxel_mm});
  out.depth = measure_depth(map);
  if (!out.depth) return out;
  out.face = find_face(map, voxel_mm);
  out.joint_line = measure_joint_line(bone, map, *out.face, axes);
  out.orientation = measure_orientation(*out.joint_line, *out.face, bone_from_tool.linear().col(2), axes);
  out.versions = measure_versions(out.orientation->native, axes);
  out.remaining_dense = remaining_dense_bone(bone, map, *out.face, settings.dense_g_cm3);
  out.perforation = find_perforation(map, voxel_mm);
  if (settings.implant)
    out.planning = measure_planning(bone, bone_from_tool, *out.joint_line, axes, settings, implant_mesh);
  return out;
}

ColumnMap depth_map(const BoneView& bone, const std::optional<GlenoidFrame>& glenoid, const Rigid& bone_from_tool) {
  return map_columns(bone, glenoid ? glenoid->bone_from_glenoid : bone_from_tool, {.margin_mm = kDepthMapMargin_mm});
}

}  // namespace reamsim
