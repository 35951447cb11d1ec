#include <cmath>

#include "assets/reamer_shapes.h"

namespace reamsim::assets {

namespace {

constexpr double kShaftRadiusMm = 4;
constexpr double kShaftChamferMm = 0.5;

/// Points of a spherical face from the cannula to `rim_radius`, centre of the sphere on the axis above the origin.
/// Equal steps of angle, so that each chord is as far from the sphere as the next.
void add_spherical_face(Profile& profile, double curvature, double rim_radius, int edges) {
  const double first = std::asin(kCannulaRadiusMm / curvature), last = std::asin(rim_radius / curvature);
  for (int i = 0; i <= edges; ++i) {
    const double angle = first + (last - first) * i / edges;
    profile.points.emplace_back(curvature * std::sin(angle), curvature * (1 - std::cos(angle)));
  }
  profile.points.front().x() = kCannulaRadiusMm;
  profile.points.back().x() = rim_radius;
}

/// Hub and shaft: from the back of the head at `hub_radius` up to the shaft's end, and in to the cannula, which the
/// polygon's closing edge bores.
void add_hub_and_shaft(Profile& profile, double hub_radius, double hub_top, double shaft_top) {
  profile.points.emplace_back(hub_radius, hub_top - 1.5);
  profile.points.emplace_back(kShaftRadiusMm, hub_top);
  profile.points.emplace_back(kShaftRadiusMm, shaft_top - kShaftChamferMm);
  profile.points.emplace_back(kShaftRadiusMm - kShaftChamferMm, shaft_top);
  profile.points.emplace_back(kCannulaRadiusMm, shaft_top);
}

}  // namespace

Profile hemispherical_profile() {
  Profile profile;
  add_spherical_face(profile, kHemisphereRadiusMm, kHemisphereRadiusMm, 41);
  profile.points.emplace_back(14, 15.5);
  profile.points.emplace_back(13.2, 16.3);
  profile.points.emplace_back(6.5, 16.3);
  add_hub_and_shaft(profile, 6.5, 19.5, 34);
  return profile;
}

Profile convex_profile() {
  Profile profile;
  add_spherical_face(profile, kConvexCurvatureMm, kConvexRadiusMm, 18);
  profile.points.emplace_back(15, 5.8);
  profile.points.emplace_back(14.4, 6.4);
  profile.points.emplace_back(6.5, 4.8);
  add_hub_and_shaft(profile, 6.5, 10.5, 30);
  return profile;
}

Profile flat_profile() {
  Profile profile;
  profile.points.emplace_back(kCannulaRadiusMm, 0);
  profile.points.emplace_back(kFlatRadiusMm, 0);
  profile.points.emplace_back(13.5, 2.9);
  profile.points.emplace_back(12.9, 3.5);
  profile.points.emplace_back(6.5, 3.5);
  add_hub_and_shaft(profile, 6.5, 8.5, 27);
  return profile;
}

}  // namespace reamsim::assets
