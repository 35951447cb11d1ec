// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "assets/reamer_shapes.h"

namespace reamsim::assets {

namespace {

constexpr double kShaftRadiusMm = 4;
constexpr double kShaftChamferMm = 0.5;

/// Points of a spherical face from the cannula to `rim_radius`; the centre of the sphere is on the axis above the
/// origin. Equal angles give every chord the same distance to the sphere.
void add_spherical_face(Profile& profile, double curvature, double rim_radius, int edges) {
  const double first = std::asin(kCannulaRadiusMm / curvature), last = std::asin(rim_radius / curvature);
  for (int i = 0; i <= edges; ++i) {
    const double angle = first + (last - first) * i / edges;
    profile.points.emplace_back(curvature * std::sin(angle), curvature * (1 - std::cos(angle)));
  }
  profile.points.front().x() = kCannulaRadiusMm;
  profile.points.back().x() = rim_radius;
}

void add_points(Profile& profile, std::initializer_list<Vec2> points) {
  profile.points.insert(profile.points.end(), points);
}

/// Hub and shaft: from the back of the head at the hub's radius up to the end of the shaft, and in to the cannula,
/// which the closing edge of the polygon bounds.
void add_hub_and_shaft(Profile& profile, double hub_top, double shaft_top) {
  constexpr double kHubRadiusMm = 6.5;
  add_points(profile, {{kHubRadiusMm, hub_top - 1.5},
                       {kShaftRadiusMm, hub_top},
                       {kShaftRadiusMm, shaft_top - kShaftChamferMm},
                       {kShaftRadiusMm - kShaftChamferMm, shaft_top},
                       {kCannulaRadiusMm, shaft_top}});
}

constexpr int kCuttingEdges = 6;
constexpr double kDegree = std::numbers::pi / 180;
/// Set-back of the face between the cutting edges, and the radii between which it grows to that.
constexpr double kRecessMm = 0.9;
constexpr double kRecessStartMm = kCannulaRadiusMm, kRecessFullMm = 5;
/// Angles of the sector of one tooth. The tool rotates towards smaller angles. From 0 on: cutting edge, land, relief,
/// and the chip slot before the next cutting edge.
constexpr double kLandEnd = 3 * kDegree, kReliefEnd = 34 * kDegree, kSlotStart = 37 * kDegree;
/// The outer parts of the cutting edges trail.
constexpr double kSpiralPerMm = 1.4 * kDegree;
/// Radii of the slot.
constexpr double kSlotInnerMm = 7.4, kSlotOuterMm = 13.2;

/// Columns of the grid within a sector: fine near the cutting edge, with a column at each edge of the slot.
std::vector<double> sector_angles() {
  std::vector<double> angles{0, 1.5, 3};
  for (int i = 1; i <= 16; ++i) angles.push_back(3 + 2.125 * i);  // to the slot's start at 37°
  for (int i = 1; i <= 10; ++i) angles.push_back(37 + 2.2 * i);   // to 59°
  angles.push_back(59.4);
  for (double& a : angles) a *= kDegree;
  return angles;
}

/// Set-back of the face, mm, at radius r and angle behind the cutting edge.
double recess(double radius, double angle) {
  const double radial = std::clamp((radius - kRecessStartMm) / (kRecessFullMm - kRecessStartMm), 0.0, 1.0);
  const double angular = std::clamp((angle - kLandEnd) / (kReliefEnd - kLandEnd), 0.0, 1.0);
  return kRecessMm * radial * angular;
}

/// The generating polygon. For each face point of the slot it has a point of equal radius on the back of the head, so
/// that the walls of the slot connect ring to ring.
struct Rings {
  std::vector<Vec2> points;
  std::size_t face_end = 0;                             ///< the rim's ring, last of the face
  std::size_t slot_face_first = 0, slot_face_last = 0;  ///< rings of the slot's inner and outer wall on the face
  std::size_t slot_back_first = 0, slot_back_last = 0;  ///< the same on the back: outer wall first
};

Rings slotted_rings() {
  const Profile profile = convex_profile();
  Rings rings;
  for (const Vec2& p : profile.points) {
    if (rings.face_end != 0 && rings.points.back().x() > kSlotOuterMm && p.x() < kSlotInnerMm) {
      const Vec2 from = rings.points.back();
      rings.slot_back_first = rings.points.size();
      for (std::size_t i = rings.slot_face_last + 1; i-- > rings.slot_face_first;) {
        const double radius = rings.points[i].x(), fraction = (from.x() - radius) / (from.x() - p.x());
        rings.points.emplace_back(radius, from.y() + fraction * (p.y() - from.y()));
      }
      rings.slot_back_last = rings.points.size() - 1;
    }
    rings.points.push_back(p);
    if (rings.face_end != 0) continue;
    const std::size_t here = rings.points.size() - 1;
    if (p.x() < kSlotInnerMm) rings.slot_face_first = here + 1;
    if (p.x() <= kSlotOuterMm) rings.slot_face_last = here;
    if (p.x() == kConvexRadiusMm) rings.face_end = here;
  }
  return rings;
}

/// The mesh of rings by columns, both closed.
class CuttingEdgeGrid {
 public:
  CuttingEdgeGrid() : rings_(slotted_rings()), sector_(sector_angles()) {
    columns_ = kCuttingEdges * sector_.size();
    for (std::size_t ring = 0; ring < rings_.points.size(); ++ring)
      for (std::size_t column = 0; column < columns_; ++column) mesh_.vertices.push_back(vertex(ring, column));
  }

  TriangleMesh build() {
    for (std::size_t ring = 0; ring < rings_.points.size(); ++ring)
      for (std::size_t column = 0; column < columns_; ++column)
        if (!(in_slot(column) && crosses_slot(ring)))
          add_quad(at(ring, column), at(ring, column + 1), at(ring + 1, column + 1), at(ring + 1, column));
    for (std::size_t column = 0; column < columns_; ++column)
      if (in_slot(column)) add_slot_walls(column);
    return mesh_;
  }

 private:
  [[nodiscard]] Vec3 vertex(std::size_t ring, std::size_t column) const {
    const Vec2& rz = rings_.points[ring];
    const double within = sector_[column % sector_.size()];
    const double angle = within + 2 * std::numbers::pi / kCuttingEdges * static_cast<double>(column / sector_.size()) +
                         kSpiralPerMm * rz.x();
    const double set_back = ring <= rings_.face_end ? recess(rz.x(), within) : 0.0;
    return {rz.x() * std::cos(angle), rz.x() * std::sin(angle), rz.y() + set_back};
  }

  [[nodiscard]] std::int32_t at(std::size_t ring, std::size_t column) const {
    return static_cast<std::int32_t>((ring % rings_.points.size()) * columns_ + column % columns_);
  }

  /// Whether the slot opens between this column and the next.
  [[nodiscard]] bool in_slot(std::size_t column) const { return sector_[column % sector_.size()] > kSlotStart - 1e-9; }

  /// Whether the slot opens between this ring and the next.
  [[nodiscard]] bool crosses_slot(std::size_t ring) const {
    return (ring >= rings_.slot_face_first && ring < rings_.slot_face_last) ||
           (ring >= rings_.slot_back_first && ring < rings_.slot_back_last);
  }

  /// The back ring of the same radius as face ring `ring` of the slot.
  [[nodiscard]] std::size_t behind(std::size_t ring) const {
    return rings_.slot_back_last - (ring - rings_.slot_face_first);
  }

  /// Corners counter-clockwise seen from outside.
  void add_quad(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) {
    mesh_.triangles.push_back({a, b, c});
    mesh_.triangles.push_back({a, c, d});
  }

  /// Each wall replaces the missing quad beside it, with the same orientation of the shared edges.
  void add_slot_walls(std::size_t column) {
    const std::size_t inner = rings_.slot_face_first, outer = rings_.slot_face_last;
    add_quad(at(inner, column), at(inner, column + 1), at(behind(inner), column + 1), at(behind(inner), column));
    add_quad(at(outer, column + 1), at(outer, column), at(behind(outer), column), at(behind(outer), column + 1));
    for (std::size_t ring = inner; ring < outer; ++ring) {
      if (!in_slot(column + columns_ - 1))
        add_quad(at(ring + 1, column), at(ring, column), at(behind(ring), column), at(behind(ring + 1), column));
      if (!in_slot(column + 1))
        add_quad(at(ring, column + 1), at(ring + 1, column + 1), at(behind(ring + 1), column + 1),
                 at(behind(ring), column + 1));
    }
  }

  Rings rings_;
  std::vector<double> sector_;
  std::size_t columns_ = 0;
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh convex_with_cutting_edges() {
  return CuttingEdgeGrid().build();
}

Profile hemispherical_profile() {
  Profile profile;
  add_spherical_face(profile, kHemisphereRadiusMm, kHemisphereRadiusMm, 41);
  add_points(profile, {{14, 15.5}, {13.2, 16.3}, {6.5, 16.3}});
  add_hub_and_shaft(profile, 19.5, 34);
  return profile;
}

Profile convex_profile() {
  Profile profile;
  add_spherical_face(profile, kConvexCurvatureMm, kConvexRadiusMm, 18);
  add_points(profile, {{15, 5.8}, {14.4, 6.4}, {6.5, 4.8}});
  add_hub_and_shaft(profile, 10.5, 30);
  return profile;
}

Profile flat_profile() {
  Profile profile;
  add_points(profile, {{kCannulaRadiusMm, 0}, {kFlatRadiusMm, 0}, {13.5, 2.9}, {12.9, 3.5}, {6.5, 3.5}});
  add_hub_and_shaft(profile, 8.5, 27);
  return profile;
}

Profile drill_profile() {
  constexpr double kRadiusMm = 1.6, kLengthMm = 20;
  const double point_mm = kRadiusMm / std::tan(59 * kDegree);
  return {{{0, 0}, {kRadiusMm, point_mm}, {kRadiusMm, kLengthMm}, {0, kLengthMm}}};
}

}  // namespace reamsim::assets
