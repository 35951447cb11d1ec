#include "sim/metrics/under_face.h"

#include <algorithm>
#include <cmath>

#include "sim/base/statistics.h"

namespace reamsim {

namespace {

constexpr double kStepVoxels = 0.5;
constexpr double kFaceBandVoxels = 1.5;  // uncertainty of the face
constexpr double kHalfFraction = 0.5;
constexpr double kNothing = 1e-6;
constexpr double kStepDownVoxels = 1;  // uncertainty of heights beside a wall

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
    if (!inside && fraction < kNothing) length_mm = 0;
    length_mm += fraction * step_mm;
    if (inside && fraction < kHalfFraction) {
      // Beyond the lower end, interpolation spreads the fraction over two voxels.
      for (double tail_mm = along_mm + step_mm; tail_mm < along_mm + 2 * voxel_mm; tail_mm += step_mm) {
        const double rest = fractions.at(face + tail_mm * inward).dense;
        if (rest >= kHalfFraction || rest < kNothing) break;
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

std::optional<RemainingDenseBone> remaining_dense_bone(const ReamedBone& bone, const ColumnMap& map,
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

Perforation find_perforation(const ColumnMap& map, double voxel_mm) {
  const int edge = face_edge_columns(map, voxel_mm);
  Perforation out;
  for (const ColumnGroup& group : group_columns(map, ColumnState::through)) {
    const double area_mm2 = static_cast<double>(group.columns.size()) * map.pitch_mm * map.pitch_mm;
    const bool rim = group.reaches_air ||
                     std::any_of(group.columns.begin(), group.columns.end(),
                                 [&](const ColumnPlace& place) { return is_at_edge(map, place, edge, voxel_mm); });
    if (rim) {
      out.rim_area_mm2 += area_mm2;
    } else {
      out.area_mm2 += area_mm2;
      ++out.holes;
    }
  }
  return out;
}

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
