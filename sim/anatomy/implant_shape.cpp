// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/implant_shape.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/bone/implicit.h"

namespace reamsim {

namespace {

/// Diameter of the superior circle of a pear over that of the inferior one: 19.5 mm over 26.0 mm, the means of 501
/// glenoids (Chen et al. 2023, Folia Morphol 82, 325–331).
constexpr double kPearTop = 0.75;

double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

/// The lower half of a sphere at a place; nullopt beside it.
std::optional<double> sphere_bottom(const Vec3& center, double radius, const Vec2& place) {
  const double below = radius * radius - (place - center.head<2>()).squaredNorm();
  if (below < 0) return std::nullopt;
  return center.z() - std::sqrt(below);
}

}  // namespace

ImplantShape::ImplantShape(const ImplantSettings& settings)
    : radius_mm_(settings.backside_radius_mm),
      half_width_mm_(std::max(settings.width_mm, settings.diameter_mm) / 2),
      half_height_mm_(std::max(settings.height_mm, settings.diameter_mm) / 2),
      shape_(settings.width_mm > 0 ? settings.footprint : FootprintShape::ellipse),
      augment_(settings.augment) {
  if (!augment_) return;
  toward_ = augment_->direction.head<2>().normalized();
  // The sphere turns about a line across `toward_` through the point of the back at start_mm, so that it sinks on that
  // side: in the plane of (toward_, z) a rotation by −angle.
  const double angle = radians(augment_->angle_deg);
  const Vec2 on_back(augment_->start_mm, plain_mm(augment_->start_mm * toward_).value_or(0));
  const Vec2 turned = on_back + Eigen::Rotation2Dd(-angle) * Vec2(Vec2(0, radius_mm_) - on_back);
  wedge_center_mm_ = Vec3(turned.x() * toward_.x(), turned.x() * toward_.y(), turned.y());
}

std::optional<double> ImplantShape::plain_mm(const Vec2& place) const {
  if (radius_mm_ == 0) return 0.0;
  return sphere_bottom({0, 0, radius_mm_}, radius_mm_, place);
}

std::optional<double> ImplantShape::wedge_mm(const Vec2& place) const {
  if (radius_mm_ > 0) return sphere_bottom(wedge_center_mm_, radius_mm_, place);
  return (augment_->start_mm - place.dot(toward_)) * std::tan(radians(augment_->angle_deg));
}

std::optional<double> ImplantShape::back_mm(const Vec2& place) const {
  const auto plain = plain_mm(place);
  if (!augment_) return plain;
  const auto wedge = wedge_mm(place);
  if (!plain || !wedge) return plain ? plain : wedge;
  return std::min(*plain, *wedge);
}

double ImplantShape::level_mm(const Vec2& place) const {
  const auto on_back = [&](double scale) { return covers(scale * place) && back_mm(scale * place).has_value(); };
  if (on_back(1)) return *back_mm(place);
  double inside = 0;
  double outside = 1;
  constexpr int kHalvings = 20;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (inside + outside);
    (on_back(middle) ? inside : outside) = middle;
  }
  return back_mm(inside * place).value_or(0);
}

bool ImplantShape::covers(const Vec2& place) const {
  if (!has_outline()) return true;
  if (shape_ == FootprintShape::ellipse) {
    return Vec2(place.x() / half_width_mm_, place.y() / half_height_mm_).squaredNorm() <= 1;
  }
  const double top_mm = kPearTop * half_width_mm_;
  return implicit::pear(place.x(), place.y(), half_width_mm_ - half_height_mm_, half_width_mm_,
                        half_height_mm_ - top_mm, top_mm) <= 0;
}

double ImplantShape::covered_fraction(const Vec2& center, double cell_mm) const {
  constexpr int kPoints = 8;
  int inside = 0;
  for (int n = 0; n < kPoints * kPoints; ++n) {
    const Vec2 offset = (Vec2(n % kPoints, n / kPoints) + Vec2::Constant(0.5)) / kPoints - Vec2::Constant(0.5);
    inside += covers(center + cell_mm * offset) ? 1 : 0;
  }
  return static_cast<double>(inside) / (kPoints * kPoints);
}

double ImplantShape::augment_depth_mm() const {
  if (!augment_) return 0;
  return std::max((reach_mm() * std::numbers::sqrt2 - augment_->start_mm) * std::tan(radians(augment_->angle_deg)),
                  0.0);
}

std::optional<Rigid> implant_pose(const ImplantSettings& settings, const Rigid& bone_from_tool, const BoneAxes& axes) {
  Rigid bone_from_frame = Rigid::Identity();
  if (settings.frame == ImplantFrame::reamer) bone_from_frame = bone_from_tool;
  if (settings.frame == ImplantFrame::glenoid) {
    if (!axes.bone_from_glenoid) return std::nullopt;
    bone_from_frame = *axes.bone_from_glenoid;
  }
  const Mat3 turn = bone_from_frame.linear();
  const Vec3 outward = (turn * settings.axis).normalized();
  const auto& anatomy = axes.glenoid ? axes.glenoid : axes.scapula;
  Vec3 superior = anatomy ? anatomy->superior : Vec3(turn.col(1));
  if (settings.superior) superior = (turn * *settings.superior).normalized();
  Vec3 across = superior.cross(outward);
  constexpr double kParallel = 1e-3;
  if (across.norm() < kParallel) across = outward.unitOrthogonal();
  across.normalize();
  Rigid bone_from_implant = Rigid::Identity();
  bone_from_implant.linear() << across, outward.cross(across), outward;
  bone_from_implant.translation() = bone_from_frame * settings.center_mm;
  return bone_from_implant;
}

}  // namespace reamsim
