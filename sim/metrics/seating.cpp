#include "sim/metrics/seating.h"

#include <algorithm>
#include <cmath>

#include "sim/metrics/statistics.h"

namespace reamsim {

namespace {

/// Marks the core that projects from the face: unreamed bone that the reamed face surrounds.
std::vector<std::uint8_t> mark_core(const ColumnMap& map, const ReamedFace& face, double voxel_mm) {
  std::vector<std::uint8_t> core(map.columns.size(), 0);
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

/// Height of the implant's back above its apex; nullopt beside the implant.
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
  const auto is_core = [&](const ColumnPlace& place) { return core[map.index(place)] != 0; };
  std::vector<ColumnPlace> out;
  map.for_each([&](const ColumnPlace& place) {
    if (map.center_mm(place).norm() > implant.diameter_mm / 2) return;
    if (!any_nearby(map, place, face_edge_columns(map, voxel_mm), is_core)) out.push_back(place);
  });
  return out;
}

}  // namespace

std::optional<Seating> seat_implant(const ColumnMap& map, const ReamedFace& face, const ImplantSettings& implant,
                                    double voxel_mm) {
  if (!face.plane) return std::nullopt;
  const std::vector<ColumnPlace> places = footprint(map, face, implant, voxel_mm);
  // The height of the apex at which the back touches each column.
  std::vector<double> contacts_mm;
  for (const ColumnPlace& place : places) {
    const Column& column = map.at(place);
    const auto back_mm = back_height(implant, map.center_mm(place).norm());
    const bool bone = column.state == ColumnState::bone || column.state == ColumnState::reamed;
    if (bone && back_mm) contacts_mm.push_back(column.after_mm - *back_mm);
  }
  if (contacts_mm.empty()) return std::nullopt;
  const double apex_mm = quantile(contacts_mm, 1 - kYieldingFraction);
  Seating out;
  std::size_t seated = 0;
  for (const double contact_mm : contacts_mm) {
    const double gap_mm = std::max(apex_mm - contact_mm, 0.0);
    seated += gap_mm <= implant.gap_mm ? 1 : 0;
    out.mean_gap_mm += gap_mm / static_cast<double>(contacts_mm.size());
    out.max_gap_mm = std::max(out.max_gap_mm, gap_mm);
  }
  const auto columns = static_cast<double>(places.size());
  out.footprint_mm2 = columns * map.pitch_mm * map.pitch_mm;
  out.seated_percent = 100 * static_cast<double>(seated) / columns;
  return out;
}

}  // namespace reamsim
