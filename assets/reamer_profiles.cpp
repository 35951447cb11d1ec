// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <cmath>

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

}  // namespace

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

}  // namespace reamsim::assets
