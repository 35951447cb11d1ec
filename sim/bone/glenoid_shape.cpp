// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/bone/implicit.h"
#include "sim/bone/phantom.h"

namespace reamsim {

namespace {

/// Upper radius of the pear-shaped outline over the lower one, which is half the width.
constexpr double kUpperRadiusRatio = 0.68;

/// Height of a concave sphere above its lowest point, at a distance from its axis.
double rise_mm(double radius_mm, double from_axis_mm) {
  return radius_mm - std::sqrt(radius_mm * radius_mm - from_axis_mm * from_axis_mm);
}

using implicit::pear, implicit::polygon, implicit::smooth_intersection, implicit::smooth_union, implicit::smoothstep;

constexpr double kRimBlend_mm = 2.4;    // rounds the rim to a radius of about 1.2 mm
constexpr double kWornRimBlend_mm = 4;  // for the acute rim of a worn face
constexpr double kCoracoidBlend_mm = 4;
constexpr double kCrestBlend_mm = 5;
constexpr double kRimLoss_mm = 0.35;       // compensates the loss of outline by the rounding
constexpr double kStumpLength_mm = 17;     // of blade, border and spine behind the neck
constexpr double kReferenceWidth_mm = 26;  // the face of the proportions below
constexpr double kReferenceHeight_mm = 35;
constexpr double kReferenceVault_mm = 28;

/// The humeral head moves along the Friedman axis, with its centre on a parallel to the axis of the native face.
void wear_concentrically(const PhantomSettings& settings, GlenoidFace& face) {
  if (settings.medialization_mm > settings.vault_depth_mm / 2) {
    fail_phantom("medialization_mm", settings.medialization_mm,
                 fmt::format("expected at most half of vault_depth_mm: {:.4g} mm", settings.vault_depth_mm / 2));
  }
  face.balls.push_back(
      {settings.wear_radius_mm * face.normal - settings.medialization_mm * Vec3::UnitX(), settings.wear_radius_mm});
}

/// Distance of the nominal outline from the centre in a direction of the face.
double outline_mm(const PhantomSettings& settings, double superior, double anterior) {
  const double half_width_mm = settings.width_mm / 2, height_mm = settings.height_mm;
  const auto inside = [&](double at_mm) {
    return implicit::pear(at_mm * anterior, at_mm * superior, half_width_mm - height_mm / 2, half_width_mm,
                          height_mm / 2 - kUpperRadiusRatio * half_width_mm, kUpperRadiusRatio * half_width_mm) < 0;
  };
  return implicit::bisect(0, height_mm, 60, inside).inside;
}

/// The ball of the humeral head passes through ridge and rim of the neoglenoid, in the plane of the native axis and the
/// wear direction.
void wear_one_side(const PhantomSettings& settings, GlenoidFace& face) {
  const double direction = implicit::radians(settings.wear_direction_deg);
  const double tilt = implicit::radians(settings.wear_tilt_deg);
  const double native_mm = settings.face_radius_mm;
  const double ridge_at_mm = settings.wear_ridge_mm;
  const Vec3 axis = face.native_normal();
  const Vec3 wear = -std::sin(direction) * Vec3(face.face_from_anatomy.row(1)) -
                    std::cos(direction) * Vec3(face.face_from_anatomy.row(2));
  const double worn_rim_mm = outline_mm(settings, -std::sin(direction), -std::cos(direction));
  const double kept_rim_mm = outline_mm(settings, std::sin(direction), std::cos(direction));
  if (ridge_at_mm <= -0.9 * kept_rim_mm || ridge_at_mm >= 0.9 * worn_rim_mm) {
    const double limit_mm = ridge_at_mm < 0 ? -0.9 * kept_rim_mm : 0.9 * worn_rim_mm;
    fail_phantom("wear_ridge_mm", ridge_at_mm,
                 fmt::format("expected a ridge on the face, short of {:.4g} mm", limit_mm));
  }
  const double chord_mm = (worn_rim_mm - ridge_at_mm) / std::cos(tilt);
  if (settings.wear_radius_mm < 0.6 * chord_mm) {
    fail_phantom("wear_radius_mm", settings.wear_radius_mm,
                 fmt::format("expected at least 0.6 of the neoglenoid's length: {:.4g} mm", 0.6 * chord_mm));
  }
  GlenoidFace::Biconcavity& both = face.biconcavity.emplace();
  both.wear = wear;
  both.ridge_mm = ridge_at_mm * wear + rise_mm(native_mm, ridge_at_mm) * axis;
  both.neo_normal = std::cos(tilt) * axis + std::sin(tilt) * wear;
  both.neo_rim_mm = both.ridge_mm + chord_mm * (std::cos(tilt) * wear - std::sin(tilt) * axis);
  const double half_chord = std::asin(chord_mm / (2 * settings.wear_radius_mm));
  both.angle = tilt + half_chord + std::asin(ridge_at_mm / native_mm);
  const Vec3 middle_mm = (both.ridge_mm + both.neo_rim_mm) / 2;
  face.balls.push_back(
      {middle_mm + settings.wear_radius_mm * std::cos(half_chord) * both.neo_normal, settings.wear_radius_mm});
  const Vec3 kept_mm = -kept_rim_mm * wear + rise_mm(native_mm, kept_rim_mm) * axis;
  const Vec3 across = both.neo_rim_mm - kept_mm;
  face.normal = (across.dot(wear) * axis - across.dot(axis) * wear).normalized();
}

}  // namespace

double version_of(const Vec3& direction) {
  return std::atan2(-direction.z(), direction.x());
}

double inclination_of(const Vec3& direction) {
  return std::asin(std::clamp(direction.y() / direction.norm(), -1.0, 1.0));
}

GlenoidFace::GlenoidFace(const PhantomSettings& settings) {
  const double version = implicit::radians(settings.version_deg);
  const double inclination = implicit::radians(settings.inclination_deg);
  normal = Vec3(std::cos(version) * std::cos(inclination), std::sin(inclination),
                -std::sin(version) * std::cos(inclination));
  const Vec3 superior = (Vec3::UnitY() - normal.y() * normal).normalized();
  face_from_anatomy << normal.transpose(), superior.transpose(), normal.cross(superior).transpose();
  balls = {{settings.face_radius_mm * normal, settings.face_radius_mm}};
  if (settings.walch == Walch::a1 || settings.walch == Walch::a2) wear_concentrically(settings, *this);
  if (settings.walch == Walch::b2) wear_one_side(settings, *this);
  for (const Ball& ball : balls) {
    const double from_axis2 = ball.center_mm.tail<2>().squaredNorm();
    const double radius2 = ball.radius_mm * ball.radius_mm;
    if (from_axis2 >= radius2) continue;
    center_mm.x() = std::min(center_mm.x(), ball.center_mm.x() - std::sqrt(radius2 - from_axis2));
  }
}

std::optional<Vec3> GlenoidFace::at(double superior, double anterior, double below_mm) const {
  std::optional<double> deepest_mm;
  for (const Ball& ball : balls) {
    const Vec3 center = face_from_anatomy * ball.center_mm;
    const double from_axis = std::hypot(superior - center.y(), anterior - center.z());
    const double radius_mm = ball.radius_mm + below_mm;
    if (from_axis >= radius_mm) continue;
    const double normal_mm = center.x() - std::sqrt(radius_mm * radius_mm - from_axis * from_axis);
    deepest_mm = std::min(deepest_mm.value_or(normal_mm), normal_mm);
  }
  if (!deepest_mm) return std::nullopt;
  return face_from_anatomy.transpose() * Vec3(*deepest_mm, superior, anterior);
}

double GlenoidFace::below_mm(const Vec3& point) const {
  double out = std::numeric_limits<double>::infinity();
  for (const Ball& ball : balls) out = std::min(out, (point - ball.center_mm).norm() - ball.radius_mm);
  return out;
}

GlenoidShape::GlenoidShape(const PhantomSettings& settings)
    : face_(settings),
      half_width_mm_(settings.width_mm / 2),
      height_mm_(settings.height_mm),
      vault_depth_mm_(settings.vault_depth_mm),
      rim_mm_(settings.walch == Walch::a1 || settings.walch == Walch::a2 ? kWornRimBlend_mm : kRimBlend_mm),
      posteroinferior_rim_mm_(settings.walch == Walch::c ? settings.rim_rounding_mm : rim_mm_) {
  place_stumps(settings.face_radius_mm);
}

void GlenoidShape::place_stumps(double face_radius_mm) {
  const double wide = 2 * half_width_mm_ / kReferenceWidth_mm;
  const double tall = height_mm_ / kReferenceHeight_mm;
  const double deep = vault_depth_mm_ / kReferenceVault_mm;
  medial_end_mm_ = -(vault_depth_mm_ + kStumpLength_mm);
  const auto at = [&](double lateral, double superior, double anterior) {
    return Vec3(deep * lateral, tall * superior, wide * anterior);
  };
  const auto outline_at = [&](double lateral, double other, double scale) {
    return Vec2(deep * lateral, scale * other);
  };
  const double thick = std::sqrt(wide * tall);
  coracoid_ = {{at(-18, 9, 1), 9.0 * thick, at(-13, 20, 6), 7.0 * thick},
               {at(-13, 20, 6), 7.0 * thick, at(-9, 25, 13), 5.6 * thick},
               {at(-9, 25, 13), 5.6 * thick, at(-4, 26, 20), 4.8 * thick},
               {at(-4, 26, 20), 4.8 * thick, at(2, 23, 26), 4.6 * thick}};
  for (const Rod& rod : coracoid_) {
    const Vec3 widest = Vec3::Constant(rod.radius_a + std::max(rod.growth, 0.0));
    for (const Vec3& end : {rod.a, Vec3(rod.a + rod.axis)}) {
      coracoid_mm_.extend(end - widest);
      coracoid_mm_.extend(end + widest);
    }
  }
  border_ = {at(-16, -11, 0), 5.0 * thick, at(-47, -37, -2), 3.8 * thick};
  crest_ = {at(-35, 15, -18), 3.0 * thick, at(-60, 13, -15), 2.8 * thick};
  // Lateral to this the distance from the body is at least that from this plane, less the fillets between its parts.
  body_end_mm_ = std::max(-12 * deep, -16 * deep + 5 * thick) + (6 + 5 + kCrestBlend_mm) / 4;
  // Blade in (lateral, superior), with the suprascapular notch beside the coracoid; spine in (lateral, anterior), with
  // the spinoglenoid notch towards the neck.
  blade_outline_ = {outline_at(-12, -9, tall), outline_at(-12, 12, tall), outline_at(-24, 14, tall),
                    outline_at(-30, 20, tall), outline_at(-60, 24, tall), outline_at(-60, -48, tall)};
  spine_outline_ = {outline_at(-24, 0, wide), outline_at(-31, -9, wide), outline_at(-34, -19, wide),
                    outline_at(-60, -16, wide), outline_at(-60, 0, wide)};
  bounds_mm_ = {Vec3(medial_end_mm_, -39 * tall - 5 * thick, -19 * wide - 5 * thick),
                Vec3(4 + 5 * thick, 26 * tall + 6 * thick, 27 * wide + 6 * thick)};
  // The rim of a tilted face extends beyond the box of the upright one.
  const double reach_mm = std::hypot(half_width_mm_, height_mm_ / 2) + 2;
  const double rim_mm =
      face_radius_mm - std::sqrt(std::max(face_radius_mm * face_radius_mm - reach_mm * reach_mm, 0.0));
  const double lateral = face_.native_normal().x();
  const double swing_mm = reach_mm * std::sqrt(1 - lateral * lateral) + rim_mm;
  bounds_mm_.max = bounds_mm_.max.cwiseMax(Vec3(swing_mm + 1, reach_mm + rim_mm, reach_mm + rim_mm));
  bounds_mm_.min = bounds_mm_.min.cwiseMin(Vec3(medial_end_mm_, -reach_mm - rim_mm, -reach_mm - rim_mm));
}

/// Coordinates of the face near the face, those of the body near the neck, with a smooth transition.
Vec3 GlenoidShape::in_face(const Vec3& point) const {
  const double turned = smoothstep(-vault_depth_mm_, -0.35 * vault_depth_mm_, point.x());
  return point + turned * (face_.face_from_anatomy * point - point);
}

/// The pear narrows from the outline of the face to that of the neck, faster near the rim.
double GlenoidShape::vault(const Vec3& q) const {
  const double depth = -q.x();
  const double fraction = std::clamp(depth / vault_depth_mm_, 0.0, 1.0);
  const double narrowing = 1 - std::pow(1 - fraction, 1.9);
  const double curl_mm = 0.25 * std::max(-depth, 0.0);  // in front of the face plane the rim leans inwards
  const double low_radius = half_width_mm_ * (1 - 0.55 * narrowing) + kRimLoss_mm - curl_mm;
  const double high_radius = kUpperRadiusRatio * half_width_mm_ * (1 - 0.30 * narrowing) + kRimLoss_mm - curl_mm;
  const double low = -(height_mm_ / 2 - half_width_mm_) - 0.045 * height_mm_ * narrowing;
  const double high = height_mm_ / 2 - kUpperRadiusRatio * half_width_mm_ - 0.03 * height_mm_ * narrowing;
  const double notch_at = (q.y() - 0.19 * height_mm_) / (0.11 * height_mm_);
  const double wall_mm = pear(q.z(), q.y(), low, low_radius, high, high_radius);
  if (q.z() <= 0) return wall_mm;
  return wall_mm + 0.13 * half_width_mm_ * std::exp(-notch_at * notch_at) * smoothstep(0, 0.5 * half_width_mm_, q.z()) *
                       (1 - narrowing);
}

/// Width of the rim's rounding: uniform except at the posteroinferior part of a dysplastic face.
double GlenoidShape::rim_blend_mm(const Vec3& q) const {
  const double posteroinferior_mm = -0.5 * q.y() - 0.5 * std::numbers::sqrt3 * q.z();
  return rim_mm_ + (posteroinferior_rim_mm_ - rim_mm_) * smoothstep(0, 0.8 * half_width_mm_, posteroinferior_mm);
}

/// The thin plate between lateral border, spine and upper edge, concave in front and thicker towards the neck, with the
/// border.
double GlenoidShape::blade(const Vec3& point) const {
  const double middle_mm = -0.0035 * point.y() * point.y() * smoothstep(-12, -40, point.x());
  const double half_thickness_mm = 1.7 + 1.6 * smoothstep(-38, -22, point.x());
  const double plate = std::abs(point.z() - middle_mm) - half_thickness_mm;
  return smooth_union(border_.distance(point), plate, 6.0, [&] {
    return smooth_intersection(plate, polygon({point.x(), point.y()}, blade_outline_), 2.0);
  });
}

double GlenoidShape::body(const Vec3& point) const {
  const double middle_mm = 9 - 0.28 * point.z();
  const double fin = std::abs(point.y() - middle_mm) - 1.9;
  const double crest = crest_.distance(point);
  return smooth_union(blade(point), std::min(fin, crest) - kCrestBlend_mm / 4, 5.0, [&] {
    return smooth_union(crest, fin, kCrestBlend_mm, [&] {
      return smooth_intersection(fin, polygon({point.x(), point.z()}, spine_outline_), 2.0);
    });
  });
}

double GlenoidShape::coracoid(const Vec3& point) const {
  double out = coracoid_[0].distance(point);
  for (std::size_t i = 1; i < coracoid_.size(); ++i) {
    out = smooth_union(out, coracoid_[i].distance(point), kCoracoidBlend_mm);
  }
  return out;
}

double GlenoidShape::stumps(const Vec3& point, double limit) const {
  constexpr double kFillet_mm = kCoracoidBlend_mm / 4;  // what each union adds at most
  const double outside_mm = (coracoid_mm_.min - point).cwiseMax(point - coracoid_mm_.max).maxCoeff();
  const double least_coracoid = outside_mm - kFillet_mm * static_cast<double>(coracoid_.size() - 1);
  const double least_body = point.x() - body_end_mm_;
  if (std::min(least_coracoid, least_body) - kFillet_mm >= limit) return limit;
  if (least_body < least_coracoid) {
    return smooth_union(body(point), least_coracoid, kCoracoidBlend_mm, [&] { return coracoid(point); });
  }
  return smooth_union(coracoid(point), least_body, kCoracoidBlend_mm, [&] { return body(point); });
}

std::vector<Vec3> GlenoidShape::rim_mm(bool rounded) const {
  constexpr int kPoints = 120;
  constexpr double kOffset = 0.25;    // of the blend, where smooth_intersection() has two equal arguments
  const int turns = rounded ? 4 : 1;  // the blend varies along the rim
  std::vector<Vec3> out;
  for (int k = 0; k < kPoints; ++k) {
    const double angle = 2 * std::numbers::pi * k / kPoints;
    double below_mm = 0;
    std::optional<Vec3> point;
    for (int turn = 0; turn < turns; ++turn) {
      const auto at = [&](double from_axis_mm) {
        return face_.at(from_axis_mm * std::sin(angle), from_axis_mm * std::cos(angle), below_mm);
      };
      const auto in_wall = [&](double from_axis_mm) {
        const std::optional<Vec3> tried = at(from_axis_mm);
        return tried && vault(in_face(*tried)) < -below_mm;
      };
      point = at(implicit::bisect(0, height_mm_, 50, in_wall).inside);
      if (!point) break;
      below_mm = kOffset * rim_blend_mm(in_face(*point));
    }
    if (point) out.push_back(*point);
  }
  return out;
}

double GlenoidShape::solid(const Vec3& point) const {
  constexpr double kNeckBlend_mm = 5;
  const Vec3 q = in_face(point);
  const double rim_blend_mm = this->rim_blend_mm(q), in_front_mm = -face_.below_mm(point);
  // The vault ends inside the body, where the pear of the neck is buried.
  const double buried_mm = -q.x() - (vault_depth_mm_ + 2);
  const auto buried_vault = [&] { return smooth_intersection(vault(q), buried_mm, 6.0); };
  double out;
  if (buried_mm > 0) {
    out = smooth_union(stumps(point), buried_mm, kNeckBlend_mm, buried_vault);
  } else {
    out = buried_vault();
    if (in_front_mm - out >= rim_blend_mm) return in_front_mm;
    out = smooth_union(out, stumps(point, out + kNeckBlend_mm), kNeckBlend_mm);
  }
  return smooth_intersection(out, in_front_mm, rim_blend_mm);
}

}  // namespace reamsim
