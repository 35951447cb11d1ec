#include "sim/metrics/reamed_face.h"

#include <algorithm>
#include <cmath>

namespace reamsim {

namespace {

std::size_t index_of(const ColumnMap& map, const ColumnPlace& place) {
  return static_cast<std::size_t>(place.x()) + static_cast<std::size_t>(map.nx) * static_cast<std::size_t>(place.y());
}

/// Adds what touches `place` to the group, and notes what it touches beside.
void visit_neighbours(const ColumnMap& map, ColumnState state, const ColumnPlace& place, ColumnGroup& group,
                      std::vector<std::uint8_t>& seen) {
  for (int dj = -1; dj <= 1; ++dj) {
    for (int di = -1; di <= 1; ++di) {
      const ColumnPlace next = place + ColumnPlace(di, dj);
      if (!map.contains(next.x(), next.y())) {
        group.reaches_air = true;
        continue;
      }
      const ColumnState there = map.at(next.x(), next.y()).state;
      group.reaches_air |= there == ColumnState::air;
      group.reaches_through |= there == ColumnState::through;
      if (there != state || seen[index_of(map, next)] != 0) continue;
      seen[index_of(map, next)] = 1;
      group.columns.push_back(next);
    }
  }
}

bool sphere_describes(const ReamedFace& face, double voxel_mm) {
  if (!face.sphere || !face.plane || face.plane->rms_mm <= kFlatVoxels * voxel_mm) return false;
  return face.sphere->rms_mm <= kSphereGain * face.plane->rms_mm;
}

}  // namespace

double ReamedFace::height_mm(const Vec3& point) const {
  if (!spherical) return (point - plane->point_mm).dot(plane->normal);
  const double outside_mm = (point - sphere->center_mm).norm() - sphere->radius_mm;
  return concave ? -outside_mm : outside_mm;
}

Vec3 ReamedFace::inward(const Vec3& point) const {
  if (!spherical) return -plane->normal;
  const Vec3 away = (point - sphere->center_mm).normalized();
  return concave ? away : Vec3(-away);
}

bool marked_nearby(const ColumnMap& map, const std::vector<std::uint8_t>& mark, const ColumnPlace& place, int reach) {
  for (int j = std::max(place.y() - reach, 0); j <= std::min(place.y() + reach, map.ny - 1); ++j) {
    for (int i = std::max(place.x() - reach, 0); i <= std::min(place.x() + reach, map.nx - 1); ++i) {
      if (mark[index_of(map, {i, j})] != 0) return true;
    }
  }
  return false;
}

std::vector<ColumnGroup> group_columns(const ColumnMap& map, ColumnState state) {
  std::vector<ColumnGroup> groups;
  std::vector<std::uint8_t> seen(map.columns.size(), 0);
  for (int j = 0; j < map.ny; ++j) {
    for (int i = 0; i < map.nx; ++i) {
      if (map.at(i, j).state != state || seen[index_of(map, {i, j})] != 0) continue;
      seen[index_of(map, {i, j})] = 1;
      ColumnGroup group;
      group.columns.emplace_back(i, j);
      for (std::size_t k = 0; k < group.columns.size(); ++k) {
        const ColumnPlace place = group.columns[k];
        visit_neighbours(map, state, place, group, seen);
      }
      groups.push_back(std::move(group));
    }
  }
  return groups;
}

ReamedFace find_face(const ColumnMap& map, double voxel_mm) {
  ReamedFace face;
  std::vector<std::uint8_t> other(map.columns.size());
  std::transform(map.columns.begin(), map.columns.end(), other.begin(),
                 [](const Column& column) { return column.state == ColumnState::reamed ? 0 : 1; });
  if (map.columns.empty()) return face;
  const int edge = static_cast<int>(std::ceil(kFaceEdgeVoxels * voxel_mm / map.pitch_mm));
  std::vector<Vec3> after;
  std::vector<Vec3> before;
  for (int j = edge; j < map.ny - edge; ++j) {
    for (int i = edge; i < map.nx - edge; ++i) {
      if (marked_nearby(map, other, {i, j}, edge)) continue;
      face.columns.emplace_back(i, j);
      after.push_back(map.in_bone(i, j, map.at(i, j).after_mm));
      before.push_back(map.in_bone(i, j, map.at(i, j).before_mm));
    }
  }
  const Vec3 up = map.bone_from_map.linear().col(2);
  face.plane = fit_plane(after, up);
  face.plane_before = fit_plane(before, up);
  face.sphere = fit_sphere(after);
  face.spherical = sphere_describes(face, voxel_mm);
  if (face.sphere && face.plane) {
    face.concave = (face.sphere->center_mm - face.plane->point_mm).dot(face.plane->normal) > 0;
  }
  return face;
}

}  // namespace reamsim
