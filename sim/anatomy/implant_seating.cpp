// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/implant_seating.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/anatomy/column_bone.h"
#include "sim/anatomy/reamed_face.h"
#include "sim/base/statistics.h"

namespace reamsim {

namespace {

/// Columns per voxel: a finer map locates the edges of footprint and contact.
constexpr double kColumnsPerVoxel = 2;
/// The map exceeds the footprint, so that cores and holes at its edge are known, voxels.
constexpr double kMapMarginVoxels = 4;

ColumnMap map_under(const ReamedBone& bone, const Rigid& bone_from_implant, const ImplantShape& shape) {
  const double voxel_mm = bone.voxmap.grid.voxel_mm;
  return map_columns(bone, bone_from_implant,
                     {.margin_mm = voxel_mm,
                      .radius_mm = shape.has_outline() ? shape.reach_mm() + kMapMarginVoxels * voxel_mm : 0,
                      .around_axis = shape.has_outline(),
                      .below_mm = kOverhangDepth_mm + shape.augment_depth_mm(),
                      .pitch_mm = voxel_mm / kColumnsPerVoxel});
}

/// Marks the core that projects from the face: unreamed bone that the reamed face surrounds.
std::vector<std::uint8_t> mark_core(const ColumnMap& map, const ReamedFace& face, double voxel_mm) {
  std::vector<std::uint8_t> core(map.columns.size(), 0);
  if (!face.plane) return core;
  for (const ColumnGroup& group : group_columns(map, ColumnState::bone)) {
    if (group.reaches_air || group.reaches_through) continue;
    std::vector<double> heights;
    for (const ColumnPlace& place : group.columns) {
      heights.push_back(face.height_mm(map.in_bone(place, map.at(place).after_mm)));
    }
    if (mean(heights) < voxel_mm) continue;
    for (const ColumnPlace& place : group.columns) core[map.index(place)] = 1;
  }
  return core;
}

std::vector<std::uint8_t> mark_holes(const ColumnMap& map) {
  std::vector<std::uint8_t> holes(map.columns.size(), 0);
  for (const ColumnGroup& group : group_columns(map, ColumnState::through)) {
    if (group.reaches_air) continue;
    for (const ColumnPlace& place : group.columns) holes[map.index(place)] = 1;
  }
  return holes;
}

std::vector<FootprintColumn> footprint_of(const ColumnMap& map, const ImplantShape& shape, double voxel_mm) {
  const ReamedFace face = find_face(map, voxel_mm);
  const std::vector<std::uint8_t> holes = mark_holes(map);
  std::vector<FootprintColumn> out;
  const auto add = [&](const ColumnPlace& place, double weight) {
    const auto back_mm = shape.back_mm(map.center_mm(place));
    if (weight > 0 && back_mm) out.push_back({place, weight, *back_mm, holes[map.index(place)] != 0});
  };
  if (!shape.has_outline()) {
    for (const ColumnPlace& place : face.columns) add(place, 1);
    return out;
  }
  const std::vector<std::uint8_t> core = mark_core(map, face, voxel_mm);
  const auto is_core = [&](const ColumnPlace& place) { return core[map.index(place)] != 0; };
  const int edge = face_edge_columns(map, voxel_mm);
  map.for_each([&](const ColumnPlace& place) {
    if (!any_nearby(map, place, edge, is_core)) {
      add(place, shape.covered_fraction(map.center_mm(place), map.pitch_mm));
    }
  });
  return out;
}

bool has_bone(const Column& column) {
  return column.state == ColumnState::bone || column.state == ColumnState::reamed;
}

/// The height of the apex at which kYieldingFraction of the footprint with bone has yielded; nullopt without bone.
std::optional<double> resting_height(const SeatedImplant& implant) {
  std::vector<std::pair<double, double>> contacts;  // height of the apex in contact, weight
  double total = 0;
  for (const FootprintColumn& column : implant.footprint) {
    const Column& bone = implant.map.at(column.place);
    if (!has_bone(bone)) continue;
    contacts.emplace_back(bone.after_mm - column.back_mm, column.weight * bone.cover);
    total += contacts.back().second;
  }
  std::sort(contacts.begin(), contacts.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  double yielded = 0;
  for (const auto& [height_mm, weight] : contacts) {
    yielded += weight;
    if (yielded > kYieldingFraction * total) return height_mm;
  }
  return std::nullopt;
}

/// The fraction of a column that has bone within kOverhangDepth_mm under the back: its sum is exact at a straight edge.
double bone_under(const SeatedImplant& implant, const FootprintColumn& column, ColumnBone& bone) {
  constexpr double kWhole = 0.999;
  const Column& found = implant.map.at(column.place);
  const double gap_mm = implant.gap_mm(column);
  if (has_bone(found) && found.cover > kWhole) return gap_mm <= kOverhangDepth_mm ? 1 : 0;
  const double back_mm = implant.apex_mm + column.back_mm;
  return std::min(bone.largest_fraction(column.place, back_mm, back_mm - kOverhangDepth_mm), 1.0);
}

/// The fraction of a column whose bone lies within `gap_mm` under the back. The height of a column that grazes a wall
/// is a mean over both sides of the wall: there the fraction of bone at that depth counts.
double seated_fraction(const SeatedImplant& implant, const FootprintColumn& column, double gap_mm, ColumnBone& bone) {
  constexpr double kBlurVoxels = 1.5;  // of a surface across the column
  constexpr double kWhole = 0.99;
  const Column& found = implant.map.at(column.place);
  const double inside_mm = found.after_mm - kBlurVoxels * bone.voxel_mm();
  if (has_bone(found) && bone.fraction(column.place, inside_mm) >= kWhole) {
    return implant.gap_mm(column) <= gap_mm ? 1 : 0;
  }
  return bone.fraction(column.place, implant.apex_mm + column.back_mm - gap_mm);
}

}  // namespace

std::optional<SeatedImplant> place_implant(const ReamedBone& bone, const Rigid& bone_from_implant,
                                           const ImplantShape& shape, const ImplantSettings& settings) {
  SeatedImplant out;
  out.map = map_under(bone, bone_from_implant, shape);
  out.footprint = footprint_of(out.map, shape, bone.voxmap.grid.voxel_mm);
  const auto resting_mm = resting_height(out);
  if (!resting_mm) return std::nullopt;
  if (settings.seat) out.apex_mm = *resting_mm;
  out.bone_from_implant = bone_from_implant * Eigen::Translation3d(0, 0, out.apex_mm);
  return out;
}

Seating measure_seating(const ReamedBone& bone, const SeatedImplant& implant, const ImplantSettings& settings,
                        double dense_g_cm3) {
  double footprint = 0;  // sums of columns
  double covered = 0;
  double overhang = 0;
  double seated = 0;
  double gaps_mm = 0;
  double bone_mm = 0;
  double dense_mm = 0;
  Seating out;
  ColumnBone below(bone, implant.map, dense_g_cm3);
  for (const FootprintColumn& column : implant.footprint) {
    const Column& found = implant.map.at(column.place);
    const double gap_mm = implant.gap_mm(column);
    footprint += column.weight;
    if (!column.hole) overhang += column.weight * (1 - bone_under(implant, column, below));
    seated += column.weight * seated_fraction(implant, column, settings.gap_mm, below);
    if (!has_bone(found)) continue;
    const double weight = column.weight * found.cover;
    covered += weight;
    gaps_mm += weight * std::max(gap_mm, 0.0);
    out.max_gap_mm = std::max(out.max_gap_mm, gap_mm);
    const ColumnBone::Length layer = below.layer(column.place, found.after_mm, settings.support_depth_mm);
    bone_mm += column.weight * layer.bone_mm;
    dense_mm += column.weight * layer.dense_mm;
  }
  out.footprint_mm2 = footprint * implant.column_mm2();
  out.overhang_mm2 = overhang * implant.column_mm2();
  out.overhang_percent = 100 * overhang / footprint;
  out.seated_percent = 100 * seated / footprint;
  if (covered > 0) out.mean_gap_mm = gaps_mm / covered;
  if (bone_mm > 0) out.dense_percent = 100 * dense_mm / bone_mm;
  return out;
}

}  // namespace reamsim
