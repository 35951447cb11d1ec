// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/glenoid_face.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/base/error.h"
#include "sim/bone/implicit.h"

namespace reamsim {

namespace {

double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

[[noreturn]] void fail_face(const char* key, double value_mm, const std::string& expected) {
  throw InputError({}, std::string("bone.phantom.") + key, fmt::format("{:.4g} mm", value_mm), expected);
}

/// Height of a concave sphere above its lowest point, at a distance from its axis.
double rise_mm(double radius_mm, double from_axis_mm) {
  return radius_mm - std::sqrt(radius_mm * radius_mm - from_axis_mm * from_axis_mm);
}

}  // namespace

double version_of(const Vec3& direction) {
  return std::atan2(-direction.z(), direction.x());
}

double inclination_of(const Vec3& direction) {
  return std::asin(std::clamp(direction.y() / direction.norm(), -1.0, 1.0));
}

GlenoidFace::GlenoidFace(const PhantomSettings& settings)
    : half_width_mm_(settings.width_mm / 2), height_mm_(settings.height_mm) {
  const double version = radians(settings.version_deg);
  const double inclination = radians(settings.inclination_deg);
  normal_ = Vec3(std::cos(version) * std::cos(inclination), std::sin(inclination),
                 -std::sin(version) * std::cos(inclination));
  const Vec3 superior = (Vec3::UnitY() - normal_.y() * normal_).normalized();
  face_from_anatomy_ << normal_.transpose(), superior.transpose(), normal_.cross(superior).transpose();
  balls_ = {{settings.face_radius_mm * normal_, settings.face_radius_mm}};
  if (settings.walch == Walch::a1 || settings.walch == Walch::a2) wear_concentrically(settings);
  if (settings.walch == Walch::b2) wear_one_side(settings);
  place_center();
}

/// The humeral head moves along the Friedman axis, with its centre on a parallel to the axis of the native face.
void GlenoidFace::wear_concentrically(const PhantomSettings& settings) {
  if (settings.medialization_mm > settings.vault_depth_mm / 2) {
    fail_face("medialization_mm", settings.medialization_mm,
              fmt::format("expected at most half of vault_depth_mm: {:.4g} mm", settings.vault_depth_mm / 2));
  }
  balls_.push_back(
      {settings.wear_radius_mm * normal_ - settings.medialization_mm * Vec3::UnitX(), settings.wear_radius_mm});
}

/// Distance of the nominal outline from the centre in a direction of the face.
double GlenoidFace::outline_mm(double superior, double anterior) const {
  return implicit::bisect(0, height_mm_, 60, [&](double at_mm) {
    return implicit::pear(at_mm * anterior, at_mm * superior, half_width_mm_ - height_mm_ / 2, half_width_mm_,
                          height_mm_ / 2 - kUpperRadiusRatio * half_width_mm_, kUpperRadiusRatio * half_width_mm_) < 0;
  });
}

/// The ball of the humeral head passes through ridge and rim of the neoglenoid, in the plane of the native axis and the
/// wear direction.
void GlenoidFace::wear_one_side(const PhantomSettings& settings) {
  const double direction = radians(settings.wear_direction_deg);
  const double tilt = radians(settings.wear_tilt_deg);
  const double native_mm = settings.face_radius_mm;
  const double ridge_at_mm = settings.wear_ridge_mm;
  const Vec3 axis = native_normal();
  const Vec3 wear =
      -std::sin(direction) * Vec3(face_from_anatomy_.row(1)) - std::cos(direction) * Vec3(face_from_anatomy_.row(2));
  const double worn_rim_mm = outline_mm(-std::sin(direction), -std::cos(direction));
  const double kept_rim_mm = outline_mm(std::sin(direction), std::cos(direction));
  if (ridge_at_mm <= -0.9 * kept_rim_mm || ridge_at_mm >= 0.9 * worn_rim_mm) {
    const double limit_mm = ridge_at_mm < 0 ? -0.9 * kept_rim_mm : 0.9 * worn_rim_mm;
    fail_face("wear_ridge_mm", ridge_at_mm, fmt::format("expected a ridge on the face, short of {:.4g} mm", limit_mm));
  }
  const double chord_mm = (worn_rim_mm - ridge_at_mm) / std::cos(tilt);
  if (settings.wear_radius_mm < 0.6 * chord_mm) {
    fail_face("wear_radius_mm", settings.wear_radius_mm,
              fmt::format("expected at least 0.6 of the neoglenoid's length: {:.4g} mm", 0.6 * chord_mm));
  }
  biconcave_ = true;
  biconcavity_.wear = wear;
  biconcavity_.ridge_mm = ridge_at_mm * wear + rise_mm(native_mm, ridge_at_mm) * axis;
  biconcavity_.neo_normal = std::cos(tilt) * axis + std::sin(tilt) * wear;
  biconcavity_.neo_rim_mm = biconcavity_.ridge_mm + chord_mm * (std::cos(tilt) * wear - std::sin(tilt) * axis);
  const double half_chord = std::asin(chord_mm / (2 * settings.wear_radius_mm));
  biconcavity_.angle = tilt + half_chord + std::asin(ridge_at_mm / native_mm);
  const Vec3 middle_mm = (biconcavity_.ridge_mm + biconcavity_.neo_rim_mm) / 2;
  balls_.push_back(
      {middle_mm + settings.wear_radius_mm * std::cos(half_chord) * biconcavity_.neo_normal, settings.wear_radius_mm});
  const Vec3 kept_mm = -kept_rim_mm * wear + rise_mm(native_mm, kept_rim_mm) * axis;
  const Vec3 across = biconcavity_.neo_rim_mm - kept_mm;
  normal_ = (across.dot(wear) * axis - across.dot(axis) * wear).normalized();
}

void GlenoidFace::place_center() {
  for (const Ball& ball : balls_) {
    const double from_axis2 = ball.center_mm.tail<2>().squaredNorm();
    const double radius2 = ball.radius_mm * ball.radius_mm;
    if (from_axis2 >= radius2) continue;
    center_mm_.x() = std::min(center_mm_.x(), ball.center_mm.x() - std::sqrt(radius2 - from_axis2));
  }
}

std::optional<Vec3> GlenoidFace::at(double superior, double anterior, double below_mm) const {
  std::optional<double> deepest_mm;
  for (const Ball& ball : balls_) {
    const Vec3 center = face_from_anatomy_ * ball.center_mm;
    const double from_axis = std::hypot(superior - center.y(), anterior - center.z());
    const double radius_mm = ball.radius_mm + below_mm;
    if (from_axis >= radius_mm) continue;
    const double normal_mm = center.x() - std::sqrt(radius_mm * radius_mm - from_axis * from_axis);
    deepest_mm = std::min(deepest_mm.value_or(normal_mm), normal_mm);
  }
  if (!deepest_mm) return std::nullopt;
  return face_from_anatomy_.transpose() * Vec3(*deepest_mm, superior, anterior);
}

double GlenoidFace::below_mm(const Vec3& point) const {
  double out = std::numeric_limits<double>::infinity();
  for (const Ball& ball : balls_) out = std::min(out, (point - ball.center_mm).norm() - ball.radius_mm);
  return out;
}

}  // namespace reamsim
