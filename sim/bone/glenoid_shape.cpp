// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/glenoid_shape.h"

#include <numbers>

namespace reamsim {

namespace {

constexpr double kUpperRadiusRatio = GlenoidFace::kUpperRadiusRatio;

using implicit::pear;
using implicit::polygon;
using implicit::smooth_intersection;
using implicit::smooth_union;
using implicit::smoothstep;

constexpr double kRimBlend_mm = 2.4;       // rounds the rim to a radius of about 1.2 mm
constexpr double kWornRimBlend_mm = 4;     // for the acute rim of a worn face
constexpr double kRimLoss_mm = 0.35;       // compensates the loss of outline by the rounding
constexpr double kStumpLength_mm = 17;     // of blade, border and spine behind the neck
constexpr double kReferenceWidth_mm = 26;  // the face of the proportions below
constexpr double kReferenceHeight_mm = 35;
constexpr double kReferenceVault_mm = 28;

}  // namespace

GlenoidShape::GlenoidShape(const PhantomSettings& settings)
    : face_(settings),
      half_width_mm_(settings.width_mm / 2),
      height_mm_(settings.height_mm),
      face_radius_mm_(settings.face_radius_mm),
      vault_depth_mm_(settings.vault_depth_mm),
      rim_mm_(settings.walch == Walch::a1 || settings.walch == Walch::a2 ? kWornRimBlend_mm : kRimBlend_mm),
      posteroinferior_rim_mm_(settings.walch == Walch::c ? settings.rim_rounding_mm : rim_mm_) {
  place_stumps();
}

void GlenoidShape::place_stumps() {
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
  border_ = {at(-16, -11, 0), 5.0 * thick, at(-47, -37, -2), 3.8 * thick};
  crest_ = {at(-35, 15, -18), 3.0 * thick, at(-60, 13, -15), 2.8 * thick};
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
      face_radius_mm_ - std::sqrt(std::max(face_radius_mm_ * face_radius_mm_ - reach_mm * reach_mm, 0.0));
  const double lateral = face_.native_normal().x();
  const double swing_mm = reach_mm * std::sqrt(1 - lateral * lateral) + rim_mm;
  bounds_mm_.max = bounds_mm_.max.cwiseMax(Vec3(swing_mm + 1, reach_mm + rim_mm, reach_mm + rim_mm));
  bounds_mm_.min = bounds_mm_.min.cwiseMin(Vec3(medial_end_mm_, -reach_mm - rim_mm, -reach_mm - rim_mm));
}

/// Coordinates of the face near the face, those of the body near the neck, with a smooth transition.
Vec3 GlenoidShape::in_face(const Vec3& point) const {
  const double turned = smoothstep(-vault_depth_mm_, -0.35 * vault_depth_mm_, point.x());
  return point + turned * (face_.face_from_anatomy() * point - point);
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
  const double notch_mm = 0.13 * half_width_mm_ * std::exp(-notch_at * notch_at) *
                          smoothstep(0, 0.5 * half_width_mm_, q.z()) * (1 - narrowing);
  return pear(q.z(), q.y(), low, low_radius, high, high_radius) + notch_mm;
}

/// Width of the rim's rounding: uniform except at the posteroinferior part of a dysplastic face.
double GlenoidShape::rim_blend_mm(const Vec3& q) const {
  const double posteroinferior_mm = -0.5 * q.y() - 0.5 * std::numbers::sqrt3 * q.z();
  return rim_mm_ + (posteroinferior_rim_mm_ - rim_mm_) * smoothstep(0, 0.8 * half_width_mm_, posteroinferior_mm);
}

/// The thin plate between lateral border, spine and upper edge: concave in front, thicker towards the neck.
double GlenoidShape::blade(const Vec3& point) const {
  const double middle_mm = -0.0035 * point.y() * point.y() * smoothstep(-12, -40, point.x());
  const double half_thickness_mm = 1.7 + 1.6 * smoothstep(-38, -22, point.x());
  return smooth_intersection(std::abs(point.z() - middle_mm) - half_thickness_mm,
                             polygon({point.x(), point.y()}, blade_outline_), 2.0);
}

double GlenoidShape::spine(const Vec3& point) const {
  const double middle_mm = 9 - 0.28 * point.z();
  const double fin =
      smooth_intersection(std::abs(point.y() - middle_mm) - 1.9, polygon({point.x(), point.z()}, spine_outline_), 2.0);
  return smooth_union(fin, crest_.distance(point), 5.0);
}

double GlenoidShape::stumps(const Vec3& point) const {
  double out = coracoid_[0].distance(point);
  for (std::size_t i = 1; i < coracoid_.size(); ++i) out = smooth_union(out, coracoid_[i].distance(point), 4.0);
  const double body = smooth_union(smooth_union(blade(point), border_.distance(point), 6.0), spine(point), 5.0);
  return smooth_union(out, body, 4.0);
}

/// Where the surfaces that lie `rounding_mm(point)` below face and wall meet; the value may vary along the rim.
std::vector<Vec3> GlenoidShape::rim_where(const std::function<double(const Vec3&)>& rounding_mm) const {
  constexpr int kPoints = 120, kTurns = 4;
  std::vector<Vec3> out;
  for (int k = 0; k < kPoints; ++k) {
    const double angle = 2 * std::numbers::pi * k / kPoints;
    double below_mm = 0;
    std::optional<Vec3> point;
    for (int turn = 0; turn < kTurns; ++turn) {
      const auto at = [&](double from_axis_mm) {
        return face_.at(from_axis_mm * std::sin(angle), from_axis_mm * std::cos(angle), below_mm);
      };
      point = at(implicit::bisect(0, height_mm_, 50, [&](double from_axis_mm) {
        const std::optional<Vec3> tried = at(from_axis_mm);
        return tried && vault(in_face(*tried)) < -below_mm;
      }));
      if (!point) break;
      below_mm = rounding_mm(*point);
    }
    if (point) out.push_back(*point);
  }
  return out;
}

std::vector<Vec3> GlenoidShape::rim_mm() const {
  return rim_where([](const Vec3&) { return 0.0; });
}

std::vector<Vec3> GlenoidShape::rounded_rim_mm() const {
  constexpr double kOffset = 0.25;  // of the blend, where smooth_intersection() has two equal arguments
  return rim_where([this](const Vec3& point) { return kOffset * rim_blend_mm(in_face(point)); });
}

double GlenoidShape::solid(const Vec3& point) const {
  const Vec3 q = in_face(point);
  // The vault ends inside the body, where the pear of the neck is buried.
  const double buried_mm = -q.x() - (vault_depth_mm_ + 2);
  double out = smooth_intersection(vault(q), buried_mm, 6.0);
  out = smooth_union(out, stumps(point), 5.0);
  return smooth_intersection(out, -face_.below_mm(point), rim_blend_mm(q));
}

}  // namespace reamsim
