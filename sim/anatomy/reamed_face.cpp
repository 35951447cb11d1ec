// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/reamed_face.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace reamsim {

namespace {

/// Adds the neighbours of `place` that have the group's state, and records which other states it touches.
void visit_neighbours(const ColumnMap& map, ColumnState state, const ColumnPlace& place, ColumnGroup& group,
                      std::vector<std::uint8_t>& seen) {
  for (int dj = -1; dj <= 1; ++dj) {
    for (int di = -1; di <= 1; ++di) {
      const ColumnPlace next = place + ColumnPlace(di, dj);
      const bool outside = !map.contains(next);
      const ColumnState there = outside ? ColumnState::air : map.at(next).state;
      group.reaches_air |= there == ColumnState::air;
      group.reaches_through |= there == ColumnState::through;
      if (outside || there != state || std::exchange(seen[map.index(next)], true)) continue;
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

int face_edge_columns(const ColumnMap& map, double voxel_mm) {
  return static_cast<int>(std::ceil(kFaceEdgeVoxels * voxel_mm / map.pitch_mm));
}

std::vector<ColumnGroup> group_columns(const ColumnMap& map, ColumnState state) {
  std::vector<ColumnGroup> groups;
  std::vector<std::uint8_t> seen(map.columns.size(), 0);
  map.for_each([&](const ColumnPlace& start) {
    if (map.at(start).state != state || std::exchange(seen[map.index(start)], true)) return;
    ColumnGroup group;
    group.columns.push_back(start);
    for (std::size_t k = 0; k < group.columns.size(); ++k) {
      const ColumnPlace place = group.columns[k];
      visit_neighbours(map, state, place, group, seen);
    }
    groups.push_back(std::move(group));
  });
  return groups;
}

ReamedFace find_face(const ColumnMap& map, double voxel_mm) {
  ReamedFace face;
  if (map.columns.empty()) return face;
  const int edge = face_edge_columns(map, voxel_mm);
  const auto is_other = [&map](const ColumnPlace& place) { return map.at(place).state != ColumnState::reamed; };
  std::vector<Vec3> after;
  std::vector<Vec3> before;
  map.for_each([&](const ColumnPlace& place) {
    const bool inner = (place.array() >= edge).all() && place.x() < map.nx - edge && place.y() < map.ny - edge;
    if (!inner || any_nearby(map, place, edge, is_other)) return;
    face.columns.push_back(place);
    after.push_back(map.in_bone(place, map.at(place).after_mm));
    before.push_back(map.in_bone(place, map.at(place).before_mm));
  });
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
