// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/run_metrics.h"

#include <fmt/core.h>
#include <cmath>
#include <numbers>

#include "sim/base/statistics.h"
#include "sim/bone/implicit.h"

namespace reamsim {

namespace {

/// Diameter of the superior circle of a pear over that of the inferior one: 19.5 mm over 26.0 mm, the means of 501
/// glenoids (Chen et al. 2023, Folia Morphol 82, 325–331).
constexpr double kPearTop = 0.75;

/// The lower half of a sphere at a place; nullopt beside it.
std::optional<double> sphere_bottom(const Vec3& center, double radius, const Vec2& place) {
  const double below = radius * radius - (place - center.head<2>()).squaredNorm();
  if (below < 0) return std::nullopt;
  return center.z() - std::sqrt(below);
}

/// Single voxels that project from the face do not support an implant.
constexpr double kYieldingFraction = 0.01;
/// Columns per voxel: a finer map locates the edges of footprint and contact.
constexpr double kColumnsPerVoxel = 2;
/// A stepped back or a mesh that changes by more than this within a voxel, voxels, has a wall there.
constexpr double kWallVoxels = 2;
/// The map exceeds the footprint, so that cores and holes at its edge are known, voxels.
constexpr double kMapMarginVoxels = 4;

template <class Property>
std::vector<std::uint8_t> mark_groups(const ColumnMap& map, ColumnState state, const Property& property) {
  std::vector<std::uint8_t> out(map.columns.size(), 0);
  for (const ColumnGroup& group : group_columns(map, state)) {
    if (!property(group)) continue;
    for (const ColumnPlace& place : group.columns) out[map.index(place)] = 1;
  }
  return out;
}

/// Whether a group of unreamed bone is a core that projects from the face, which surrounds it.
bool is_core(const ColumnMap& map, const ReamedFace& face, double voxel_mm, const ColumnGroup& group) {
  if (!face.plane || group.reaches_air || group.reaches_through) return false;
  std::vector<double> heights;
  for (const ColumnPlace& place : group.columns) {
    heights.push_back(face.height_mm(map.in_bone(place, map.at(place).after_mm)));
  }
  return mean(heights) >= voxel_mm;
}

std::vector<FootprintColumn> footprint_of(const ColumnMap& map, const ImplantShape& shape, double voxel_mm) {
  const ReamedFace face = find_face(map, voxel_mm);
  const std::vector<std::uint8_t> holes =
      mark_groups(map, ColumnState::through, [](const ColumnGroup& group) { return !group.reaches_air; });
  std::vector<FootprintColumn> out;
  const auto add = [&](const ColumnPlace& place, double weight) {
    const Vec2 center_mm = map.center_mm(place);
    const auto back_mm = shape.back_mm(center_mm);
    if (weight <= 0 || !back_mm) return;
    const auto is_steep = [&](const Vec2& step) {
      return std::abs(shape.back_mm(center_mm + voxel_mm * step).value_or(*back_mm) - *back_mm) >
             kWallVoxels * voxel_mm;
    };
    const bool beside_wall =
        shape.may_have_walls() && (is_steep({1, 0}) || is_steep({-1, 0}) || is_steep({0, 1}) || is_steep({0, -1}));
    out.push_back({place, weight, *back_mm, holes[map.index(place)] != 0, beside_wall});
  };
  if (!shape.has_outline()) {
    for (const ColumnPlace& place : face.columns) add(place, 1);
    return out;
  }
  const std::vector<std::uint8_t> core = mark_groups(
      map, ColumnState::bone, [&](const ColumnGroup& group) { return is_core(map, face, voxel_mm, group); });
  const auto in_core = [&](const ColumnPlace& place) { return core[map.index(place)] != 0; };
  const int edge = face_edge_columns(map, voxel_mm);
  map.for_each([&](const ColumnPlace& place) {
    if (!any_nearby(map, place, edge, in_core)) {
      add(place, shape.covered_fraction(map.center_mm(place), map.pitch_mm));
    }
  });
  return out;
}

/// The height of the apex at which kYieldingFraction of the bone under those parts of the footprint that `carries` says
/// has yielded; nullopt without bone. Beside a wall of the back the height of the bone is a mean over both its sides.
template <class Carries>
std::optional<double> resting_height(const SeatedImplant& implant, const Carries& carries) {
  std::vector<std::pair<double, double>> contacts;  // height of the apex in contact, weight
  double total = 0;
  for (const FootprintColumn& column : implant.footprint) {
    const Column& bone = implant.map.at(column.place);
    if (!bone.has_bone() || column.beside_wall || !carries(column)) continue;
    contacts.emplace_back(bone.after_mm - column.back_mm, column.weight * bone.cover);
    total += contacts.back().second;
  }
  std::sort(contacts.begin(), contacts.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  double yielded = 0;
  for (const auto& [height_mm, weight] : contacts) {
    yielded += weight;
    if (yielded > kYieldingFraction * total) return height_mm;
  }
  return std::nullopt;
}

/// Sets unreamed_mm2 and held_off of a Seating with a footprint. Of the columns beside unreamed bone, which mix it with
/// the reamed face, those belong to it that stand higher above that face than they lost bone.
void measure_unreamed(const SeatedImplant& implant, bool seated, double voxel_mm, Seating& out) {
  const ColumnMap& map = implant.map;
  const int edge = face_edge_columns(map, voxel_mm);
  const auto is_unreamed = [&](const ColumnPlace& place) { return map.at(place).state == ColumnState::bone; };
  const auto on_face = [&](const FootprintColumn& column) { return !any_nearby(map, column.place, edge, is_unreamed); };
  const auto free_mm = resting_height(implant, on_face);
  const double gap_mm = implant.apex_mm - free_mm.value_or(implant.apex_mm);
  HeldOff held{.gap_mm = gap_mm};
  double highest_mm = 0;  // above the back, if the implant rested on reamed bone alone
  for (const FootprintColumn& column : implant.footprint) {
    const Column& bone = map.at(column.place);
    const double above_mm = gap_mm - implant.gap_mm(column);  // the face if it rested there
    const bool mixed = bone.state == ColumnState::reamed && above_mm > bone.depth_mm && !on_face(column);
    if (bone.state != ColumnState::bone && !mixed) continue;
    const double area_mm2 = column.weight * bone.cover * implant.column_mm2();
    out.unreamed_mm2 += area_mm2;
    if (above_mm <= 0) continue;
    held.area_mm2 += area_mm2;
    if (above_mm <= highest_mm) continue;
    highest_mm = above_mm;
    held.position_mm = map.in_bone(column.place, bone.after_mm);
  }
  const bool carries = held.area_mm2 > kYieldingFraction * out.footprint_mm2;
  if (seated && carries && gap_mm >= kMinDepthVoxels * voxel_mm) out.held_off = held;
}

/// The fraction of a column that has bone within kOverhangDepth_mm under the back: its sum is exact at a straight edge.
double bone_under(const SeatedImplant& implant, const FootprintColumn& column, ColumnBone& bone) {
  constexpr double kWhole = 0.999;
  const Column& found = implant.map.at(column.place);
  const double gap_mm = implant.gap_mm(column);
  if (found.has_bone() && found.cover > kWhole) return gap_mm <= kOverhangDepth_mm ? 1 : 0;
  const double back_mm = implant.apex_mm + column.back_mm;
  return std::min(bone.largest_fraction(column.place, back_mm, back_mm - kOverhangDepth_mm), 1.0);
}

/// The fraction of a column whose bone lies within `gap_mm` under the back. The height of a column that grazes a wall
/// is a mean over both sides of the wall: there the fraction of bone at that depth counts.
double seated_fraction(const SeatedImplant& implant, const FootprintColumn& column, double gap_mm, ColumnBone& bone) {
  constexpr double kBlurVoxels = 1.5;  // of a surface across the column
  constexpr double kWhole = 0.99;
  const Column& found = implant.map.at(column.place);
  const double inside_mm = found.after_mm - kBlurVoxels * bone.voxel_mm();
  if (found.has_bone() && bone.fraction(column.place, inside_mm) >= kWhole) {
    return implant.gap_mm(column) <= gap_mm ? 1 : 0;
  }
  return bone.fraction(column.place, implant.apex_mm + column.back_mm - gap_mm);
}

}  // namespace

ImplantShape::ImplantShape(const ImplantSettings& settings, const TriangleMesh* mesh)
    : radius_mm_(settings.backside_radius_mm),
      half_width_mm_(std::max(settings.width_mm, settings.diameter_mm) / 2),
      half_height_mm_(std::max(settings.height_mm, settings.diameter_mm) / 2),
      shape_(settings.width_mm > 0 ? settings.footprint : FootprintShape::ellipse),
      augment_(settings.augment) {
  if (mesh != nullptr && settings.mesh) {
    mesh_.emplace(*mesh, 2);
    pegs_below_mm_ = settings.mesh->pegs_below_mm;
    const Aabb box = mesh->bounds();
    half_width_mm_ = half_height_mm_ = box.max.cwiseAbs().cwiseMax(box.min.cwiseAbs()).head<2>().maxCoeff();
  }
  if (!augment_) return;
  toward_ = augment_->direction.head<2>().normalized();
  // The sphere turns about a line across `toward_` through the point of the back at start_mm, so that it sinks on that
  // side: in the plane of (toward_, z) a rotation by −angle.
  const double angle = implicit::radians(augment_->angle_deg);
  const Vec2 on_back(augment_->start_mm, plain_mm(augment_->start_mm * toward_).value_or(0));
  const Vec2 turned = on_back + Eigen::Rotation2Dd(-angle) * Vec2(Vec2(0, radius_mm_) - on_back);
  wedge_center_mm_ = Vec3(turned.x() * toward_.x(), turned.x() * toward_.y(), turned.y());
}

std::optional<double> ImplantShape::plain_mm(const Vec2& place) const {
  if (radius_mm_ == 0) return 0.0;
  return sphere_bottom({0, 0, radius_mm_}, radius_mm_, place);
}

std::optional<double> ImplantShape::augment_mm(const Vec2& place) const {
  if (augment_->shape == AugmentShape::step) {
    const auto plain = plain_mm(place);
    return plain ? std::optional(*plain - (place.dot(toward_) < augment_->start_mm ? 0 : augment_->step_mm)) : plain;
  }
  if (radius_mm_ > 0) return sphere_bottom(wedge_center_mm_, radius_mm_, place);
  return (augment_->start_mm - place.dot(toward_)) * std::tan(implicit::radians(augment_->angle_deg));
}

std::optional<double> ImplantShape::back_mm(const Vec2& place) const {
  const auto plain = plain_mm(place);
  if (!augment_ && !mesh_) return plain;
  const auto lower = mesh_ ? underside_mm(place) : augment_mm(place);
  if (mesh_) return lower && plain && is_peg({place.x(), place.y(), *lower}) ? plain : lower;
  if (!plain || !lower) return plain ? plain : lower;
  return std::min(*plain, *lower);
}

std::optional<double> ImplantShape::underside_mm(const Vec2& place) const {
  std::vector<LineCrossings::Crossing> crossings;
  mesh_->along(place.x(), place.y(), crossings);
  return crossings.empty() ? std::nullopt : std::optional(crossings.front().at_mm);
}

double ImplantShape::level_mm(const Vec2& place) const {
  const auto on_back = [&](double scale) { return covers(scale * place) && back_mm(scale * place).has_value(); };
  if (on_back(1)) return *back_mm(place);
  return back_mm(implicit::bisect(0, 1, 20, on_back).inside * place).value_or(0);
}

bool ImplantShape::covers(const Vec2& place) const {
  if (!has_outline()) return true;
  if (mesh_) return underside_mm(place).has_value();
  if (shape_ == FootprintShape::ellipse) {
    return Vec2(place.x() / half_width_mm_, place.y() / half_height_mm_).squaredNorm() <= 1;
  }
  const double top_mm = kPearTop * half_width_mm_;
  return implicit::pear(place.x(), place.y(), half_width_mm_ - half_height_mm_, half_width_mm_,
                        half_height_mm_ - top_mm, top_mm) <= 0;
}

double ImplantShape::covered_fraction(const Vec2& center, double cell_mm) const {
  const int points = mesh_ ? 4 : 8;
  int inside = 0;
  for (int n = 0; n < points * points; ++n) {
    const Vec2 offset = (Vec2(n % points, n / points) + Vec2::Constant(0.5)) / points - Vec2::Constant(0.5);
    inside += covers(center + cell_mm * offset) ? 1 : 0;
  }
  return static_cast<double>(inside) / (points * points);
}

double ImplantShape::augment_depth_mm() const {
  if (mesh_) return pegs_below_mm_;
  if (!augment_) return 0;
  if (augment_->shape == AugmentShape::step) return augment_->step_mm;
  return std::max(
      (reach_mm() * std::numbers::sqrt2 - augment_->start_mm) * std::tan(implicit::radians(augment_->angle_deg)), 0.0);
}

bool ImplantShape::is_peg(const Vec3& point) const {
  const auto plain = plain_mm(point.head<2>());
  return plain && point.z() < *plain - pegs_below_mm_;
}

double ImplantShape::back_fraction() const {
  constexpr double kStep_mm = 0.5;
  int back = 0, all = 0;
  for (double x = -reach_mm(); x <= reach_mm(); x += kStep_mm) {
    for (double y = -reach_mm(); y <= reach_mm(); y += kStep_mm) {
      const auto lower = underside_mm({x, y}), plain = plain_mm({x, y});
      if (!lower || !plain) continue;
      ++all;
      back += std::abs(*lower - *plain) <= pegs_below_mm_ ? 1 : 0;
    }
  }
  return all > 0 ? static_cast<double>(back) / all : 0;
}

std::string Seating::warning() const {
  if (unreamed_mm2 <= kYieldingFraction * footprint_mm2) return "";
  std::string out =
      fmt::format("metrics.implant: {:.0f} mm2 of its footprint of {:.0f} mm2 lie on bone that was not reamed",
                  unreamed_mm2, footprint_mm2);
  if (held_off) {
    out += fmt::format("; {:.0f} mm2 of it hold the implant off by {:.2f} mm, next to {} mm", held_off->area_mm2,
                       held_off->gap_mm, point_text(held_off->position_mm));
  }
  return out + "; ream wider or deeper, or use a smaller implant";
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

std::optional<SeatedImplant> place_implant(const BoneView& bone, const Rigid& bone_from_implant,
                                           const ImplantShape& shape, const ImplantSettings& settings) {
  SeatedImplant out;
  const double voxel_mm = bone.voxmap.grid.voxel_mm;
  out.map = map_columns(bone, bone_from_implant,
                        {.margin_mm = voxel_mm,
                         .radius_mm = shape.has_outline() ? shape.reach_mm() + kMapMarginVoxels * voxel_mm : 0,
                         .around_axis = shape.has_outline(),
                         .below_mm = kOverhangDepth_mm + shape.augment_depth_mm(),
                         .pitch_mm = voxel_mm / kColumnsPerVoxel});
  out.footprint = footprint_of(out.map, shape, voxel_mm);
  const auto resting_mm = resting_height(out, [](const FootprintColumn&) { return true; });
  if (!resting_mm) return std::nullopt;
  if (settings.seat) out.apex_mm = *resting_mm;
  out.bone_from_implant = bone_from_implant * Eigen::Translation3d(0, 0, out.apex_mm);
  return out;
}

Seating measure_seating(const BoneView& bone, const SeatedImplant& implant, const ImplantSettings& settings,
                        double dense_g_cm3) {
  double footprint = 0, covered = 0, overhang = 0, seated = 0;  // sums of columns
  double gaps_mm = 0, bone_mm = 0, dense_mm = 0;
  Seating out;
  ColumnBone below(bone, implant.map, dense_g_cm3);
  for (const FootprintColumn& column : implant.footprint) {
    const Column& found = implant.map.at(column.place);
    const double gap_mm = implant.gap_mm(column);
    footprint += column.weight;
    if (!column.hole) overhang += column.weight * (1 - bone_under(implant, column, below));
    seated += column.weight * seated_fraction(implant, column, settings.gap_mm, below);
    if (!found.has_bone()) continue;
    const double weight = column.weight * found.cover;
    covered += weight;
    gaps_mm += weight * std::max(gap_mm, 0.0);
    out.max_gap_mm = std::max(out.max_gap_mm, gap_mm);
    const ColumnBone::Length layer = below.layer(column.place, found.after_mm, settings.support_depth_mm);
    bone_mm += column.weight * layer.bone_mm;
    dense_mm += column.weight * layer.dense_mm;
  }
  out.footprint_mm2 = footprint * implant.column_mm2();
  measure_unreamed(implant, settings.seat, below.voxel_mm(), out);
  out.overhang_mm2 = overhang * implant.column_mm2();
  out.overhang_percent = 100 * overhang / footprint;
  out.seated_percent = 100 * seated / footprint;
  if (covered > 0) out.mean_gap_mm = gaps_mm / covered;
  if (bone_mm > 0) out.dense_percent = 100 * dense_mm / bone_mm;
  return out;
}

}  // namespace reamsim
