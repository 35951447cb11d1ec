#include "sim/metrics/seating.h"

#include <algorithm>
#include <cmath>

#include "sim/metrics/statistics.h"

namespace reamsim {

namespace {

/// Marks what stands out of the face in its middle: bone that was not touched, with the reamed face all round.
std::vector<std::uint8_t> mark_core(const ColumnMap& map, const ReamedFace& face, double voxel_mm) {
  std::vector<std::uint8_t> core(map.columns.size(), 0);
  for (const ColumnGroup& group : group_columns(map, ColumnState::bone)) {
    if (group.reaches_air || group.reaches_through) continue;
    std::vector<double> heights;
    for (const ColumnPlace& place : group.columns) {
      heights.push_back(face.height_mm(map.in_bone(place.x(), place.y(), map.at(place.x(), place.y()).after_mm)));
    }
    if (mean(heights) < voxel_mm) continue;
    for (const ColumnPlace& place : group.columns) {
      core[static_cast<std::size_t>(place.x()) +
           static_cast<std::size_t>(map.nx) * static_cast<std::size_t>(place.y())] = 1;
    }
  }
  return core;
}

/// Height of the implant's back over its apex; nothing beside it.
std::optional<double> back_height(const ImplantSettings& implant, double from_axis_mm) {
  if (implant.backside_radius_mm == 0) return 0.0;
  const double below = implant.backside_radius_mm * implant.backside_radius_mm - from_axis_mm * from_axis_mm;
  if (below < 0) return std::nullopt;
  return implant.backside_radius_mm - std::sqrt(below);
}

std::vector<ColumnPlace> footprint(const ColumnMap& map, const ReamedFace& face, const ImplantSettings& implant,
                                   double voxel_mm) {
  if (implant.diameter_mm == 0) return face.columns;
  const std::vector<std::uint8_t> core = mark_core(map, face, voxel_mm);
  const int edge = static_cast<int>(std::ceil(kFaceEdgeVoxels * voxel_mm / map.pitch_mm));
  std::vector<ColumnPlace> out;
  for (int j = 0; j < map.ny; ++j) {
    for (int i = 0; i < map.nx; ++i) {
      if (map.center_mm(i, j).norm() > implant.diameter_mm / 2 || marked_nearby(map, core, {i, j}, edge)) continue;
      out.emplace_back(i, j);
    }
  }
  return out;
}

}  // namespace

std::optional<Seating> seat_implant(const ColumnMap& map, const ReamedFace& face, const ImplantSettings& implant,
                                    double voxel_mm) {
  if (!face.plane) return std::nullopt;
  const std::vector<ColumnPlace> places = footprint(map, face, implant, voxel_mm);
  // How far out the apex would lie if the back touched here.
  std::vector<double> rests_mm;
  for (const ColumnPlace& place : places) {
    const Column& column = map.at(place.x(), place.y());
    const auto back_mm = back_height(implant, map.center_mm(place.x(), place.y()).norm());
    const bool bone = column.state == ColumnState::bone || column.state == ColumnState::reamed;
    if (bone && back_mm) rests_mm.push_back(column.after_mm - *back_mm);
  }
  if (rests_mm.empty()) return std::nullopt;
  const double apex_mm = quantile(rests_mm, 1 - kYieldingFraction);
  Seating out;
  std::size_t seated = 0;
  for (const double rest_mm : rests_mm) {
    const double gap_mm = std::max(apex_mm - rest_mm, 0.0);
    seated += gap_mm <= implant.gap_mm ? 1 : 0;
    out.mean_gap_mm += gap_mm / static_cast<double>(rests_mm.size());
    out.max_gap_mm = std::max(out.max_gap_mm, gap_mm);
  }
  const auto columns = static_cast<double>(places.size());
  out.footprint_mm2 = columns * map.pitch_mm * map.pitch_mm;
  out.seated_percent = 100 * static_cast<double>(seated) / columns;
  return out;
}

}  // namespace reamsim
