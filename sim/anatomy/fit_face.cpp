// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/find_glenoid.h"

#include <algorithm>
#include <iterator>
#include <numbers>

#include "sim/base/statistics.h"
#include "sim/bone/implicit.h"
#include "sim/bone/voxel_surface.h"

namespace reamsim {

double BoneProbe::fraction(const Vec3& point_mm) const {
  const VoxelGrid& grid = bone_.voxmap.grid;
  const Vec3 place = (point_mm - grid.origin_mm) / grid.voxel_mm - Vec3::Constant(0.5);
  const Vec3 base = place.array().floor();
  const Vec3i low = base.cast<int>(), brick = BrickLattice::brick_of(low);
  double out = 0;
  if (BrickLattice::brick_of(low + Vec3i::Ones()) != brick || !bone_.voxmap.grade.lattice().contains(brick)) {
    for_each_trilinear_weight(
        place - base, [&](const Vec3i& step, double weight) { out += weight * bone_fraction(bone_, low + step); });
    return out;
  }
  // All eight voxels lie in one brick, mostly one of air.
  const GradeBricks::Brick* const grades = bone_.voxmap.grade.brick(brick);
  if (grades == nullptr) return 0;
  const FillBricks::Brick* const fills = bone_.fill.brick(brick);
  const int first = BrickLattice::offset_of(low);
  for_each_trilinear_weight(place - base, [&](const Vec3i& step, double weight) {
    const auto at = static_cast<std::size_t>(first + BrickLattice::offset_of(step));
    if ((*grades)[at] == 0) return;
    out += fills == nullptr ? weight : weight * (static_cast<double>((*fills)[at]) / FillBricks::kWhole);
  });
  return out;
}

std::optional<double> BoneProbe::crossing(const Vec3& from_mm, const Vec3& direction, double most_mm,
                                          bool into_bone) const {
  const double step_mm = 0.5 * voxel_mm();
  double before = fraction(from_mm) - 0.5;
  if ((before >= 0) == into_bone) return std::nullopt;
  for (double at_mm = step_mm; at_mm <= most_mm + step_mm; at_mm += step_mm) {
    const double here = fraction(from_mm + at_mm * direction) - 0.5;
    if ((here >= 0) == into_bone) return at_mm - step_mm * here / (here - before);
    before = here;
  }
  return std::nullopt;
}

namespace {

constexpr double kFall_mm = 4;  // of the surface, that ends the face
constexpr double kFarthest_mm = 35;
constexpr double kWallRise_mm = 3;   // a surface that rises more than this in a step is a wall
constexpr double kFallReach_mm = 8;  // one that falls more ends
constexpr double kLeastStep_mm = 0.4;
/// Distance from the origin, height.
using Profile = std::vector<Vec2>;

/// The profile of the surface in a direction, until it ends or has fallen; nullopt where it does neither.
std::optional<Profile> profile_of(const BoneProbe& probe, const Rigid& bone_from_face, double angle) {
  const Vec3 along(std::cos(angle), std::sin(angle), 0), down = -bone_from_face.linear().col(2);
  const double step_mm = std::max(kLeastStep_mm, probe.voxel_mm());
  Profile out{Vec2::Zero()};
  double highest_mm = 0;
  for (double at_mm = step_mm; at_mm <= kFarthest_mm; at_mm += step_mm) {
    const double start_mm = out.back().y() + kWallRise_mm;
    const Vec3 from = bone_from_face * Vec3(at_mm * along + start_mm * Vec3::UnitZ());
    if (probe.fraction(from) >= 0.5) return std::nullopt;
    const auto fall = probe.distance_to_bone(from, down, kWallRise_mm + kFallReach_mm);
    out.emplace_back(at_mm, fall ? start_mm - *fall : highest_mm - kFall_mm);
    highest_mm = std::max(highest_mm, out.back().y());
    if (!fall || out.back().y() <= highest_mm - kFall_mm) return out;
  }
  return std::nullopt;
}

/// Walks over the surface from the origin of a frame on it in `directions` equal steps of angle. A walk ends where the
/// surface has fallen by 4 mm below its highest point or ends; the rim, in that frame, is where it has turned to fall
/// by 45 degrees. A walk has no rim where the surface rises steeply, or extends beyond 35 mm.
std::vector<Vec3> walk_to_rim(const BoneProbe& probe, const Rigid& bone_from_face, int directions) {
  std::vector<Vec3> out;
  for (int k = 0; k < directions; ++k) {
    const double angle = 2 * std::numbers::pi * k / directions;
    const auto profile = profile_of(probe, bone_from_face, angle);
    if (!profile) continue;
    // The point farthest outwards and upwards: on a rounded rim about its middle; where a gentle slope begins beside
    // the face a steeper edge would lie far down on it.
    const Vec2 corner = *std::ranges::max_element(*profile, {}, [](const Vec2& p) { return p.sum(); });
    if (corner.x() > 0) out.emplace_back(corner.x() * std::cos(angle), corner.x() * std::sin(angle), corner.y());
  }
  return out;
}

constexpr double kRest_mm = 0.01, kRest_rad = 1e-4;
constexpr double kMargin_mm = 2.5;  // from the rim, where it is rounded; at most a quarter of the radius
constexpr double kGrid_mm = 1;      // of the points of the face
constexpr double kLeastHeight_mm = 15, kMostHeight_mm = 60;  // a face is refused beyond these
constexpr double kMostConvexity_per_mm = 1.0 / 80;
/// A residual of the sphere beyond this, with the part of the face that it fits, means more than one surface.
constexpr double kOneSurface_mm = 0.55;

/// Points of the face at a distance from the outline, in B. `top_mm`: height of the rim.
std::vector<Vec3> points_inside(const BoneProbe& probe, const FittedFace& face, double top_mm) {
  const PearOutline& outline = face.fit.outline;
  const double margin_mm = std::min(kMargin_mm, outline.radius_mm / 4), reach_mm = outline.height_mm / 2;
  constexpr double kAbove_mm = 2;
  const Vec3 down = -face.bone_from_face.linear().col(2);
  std::vector<Vec3> out;
  for (double y = -reach_mm; y <= reach_mm; y += kGrid_mm) {
    for (double x = -reach_mm; x <= reach_mm; x += kGrid_mm) {
      const Vec2 place = outline.center_mm + Vec2(x, y);
      if (outline.distance_mm(place) > -margin_mm) continue;
      const Vec3 from = face.bone_from_face * Vec3(place.x(), place.y(), top_mm + kAbove_mm);
      if (const auto fall = probe.distance_to_bone(from, down, top_mm + kAbove_mm + reach_mm)) {
        out.push_back(from + *fall * down);
      }
    }
  }
  return out;
}

/// The direction out of the face at a point of it, and where it comes from.
std::optional<Vec3> normal_at(const Vec3& point_mm, const std::vector<Vec3>& points, FittedFace& face) {
  const bool one_surface = rms_distance_mm(face.surface, points) <= kOneSurface_mm;
  const Vec3 outward = face.bone_from_face.linear().col(2);
  face.normal = !one_surface ? FaceNormal::rim : face.surface.spherical ? FaceNormal::sphere : FaceNormal::plane;
  if (face.normal == FaceNormal::sphere) {
    const Vec3 way = (face.surface.sphere->center_mm - point_mm).normalized();
    return way.dot(outward) < 0 ? Vec3(-way) : way;
  }
  if (face.normal == FaceNormal::plane) return face.surface.plane.normal;
  const auto plane = fit_plane(face.rim_at_outline_mm(), Vec3::UnitZ());
  return plane ? std::optional<Vec3>(face.bone_from_face.linear() * plane->normal) : std::nullopt;
}

/// Walks, fits, and moves the frame to the middle of the face, by `moved` (mm, rad); returns whether there is a face.
bool fit_step(const BoneProbe& probe, int directions, FittedFace& face, Vec2& moved) {
  face.directions = directions;
  face.rim_mm = walk_to_rim(probe, face.bone_from_face, directions);
  std::vector<Vec2> places;
  double top_mm = 0;
  for (const Vec3& p : face.rim_mm) {
    places.push_back(p.head<2>());
    top_mm = std::max(top_mm, p.z());
  }
  const auto fit = fit_pear(places);
  if (!fit || fit->outline.height_mm > 2 * kMostHeight_mm) return false;
  face.fit = *fit;
  const std::vector<Vec3> points = points_inside(probe, face, top_mm);
  const Vec3 outward = face.bone_from_face.linear().col(2);
  const auto surface =
      fit_face({.points_mm = points, .point_mm2 = kGrid_mm * kGrid_mm, .voxel_mm = probe.voxel_mm()}, outward);
  if (!surface) return false;
  face.surface = *surface;
  const Vec2 middle = fit->outline.center_mm;
  const Vec3 from = face.bone_from_face * Vec3(middle.x(), middle.y(), top_mm + 1);
  const auto fall = probe.distance_to_bone(from, -outward, top_mm + 1 + fit->outline.radius_mm);
  if (!fall) return false;
  const Vec3 center = from - *fall * outward;
  const auto normal = normal_at(center, points, face);
  if (!normal) return false;
  moved = {(center - face.bone_from_face.translation()).norm(), std::acos(std::clamp(normal->dot(outward), -1.0, 1.0))};
  face.old_frame = face.bone_from_face;
  face.bone_from_face = frame_at(center, *normal);
  return true;
}

constexpr std::size_t kLeastPoints = 12;
constexpr double kLeastRatio = 0.5, kMostRatio = 0.95;
constexpr double kSlimmest = 2.02;  // height over the sum of radii at which both circles are one, and a margin

using Parameters = Vec6;

Parameters parameters_of(const PearOutline& o) {
  Parameters out;
  out << o.center_mm, o.axis_rad, o.height_mm, o.radius_mm, o.upper_ratio;
  return out;
}

PearOutline outline_of(const Parameters& p) {
  PearOutline out{
      .center_mm = p.head<2>(), .axis_rad = p[2], .height_mm = p[3], .radius_mm = p[4], .upper_ratio = p[5]};
  out.radius_mm = std::max(out.radius_mm, 1.0);
  out.upper_ratio = std::clamp(out.upper_ratio, kLeastRatio, kMostRatio);
  out.height_mm = std::max(out.height_mm, kSlimmest * out.radius_mm);
  return out;
}

std::vector<double> distances_of(const PearOutline& outline, const std::vector<Vec2>& points) {
  std::vector<double> out;
  const Vec2 axis = outline.axis();
  for (const Vec2& p : points) out.push_back(outline.distance_mm(p, axis));
  return out;
}

/// Tukey's biweight for residuals of the scale of the points.
std::vector<double> weights_of(const std::vector<double>& residuals) {
  constexpr double kSigmaPerMad = 1.4826, kTukey = 4.685, kLeastScale_mm = 0.2;
  std::vector<double> sizes;
  for (const double r : residuals) sizes.push_back(std::abs(r));
  const double reach = kTukey * std::max(kSigmaPerMad * quantile(sizes, 0.5), kLeastScale_mm);
  std::vector<double> out;
  for (const double r : residuals) {
    const double u = 1 - r * r / (reach * reach);
    out.push_back(u > 0 ? u * u : 0);
  }
  return out;
}

double weighted_squares(const std::vector<double>& residuals, const std::vector<double>& weights) {
  double out = 0;
  for (std::size_t i = 0; i < residuals.size(); ++i) out += weights[i] * residuals[i] * residuals[i];
  return out;
}

/// Distances of points from an outline, and the normal equations of their weighted squares.
struct OutlineEquations {
  std::vector<double> distances_mm;
  Mat6 products;
  Parameters right;
};

OutlineEquations equations_of(const PearOutline& outline, const std::vector<Vec2>& points,
                              const std::vector<double>& weights) {
  const Parameters at = parameters_of(outline);
  OutlineEquations out{.distances_mm = distances_of(outline, points), .products = {}, .right = {}};
  Eigen::MatrixXd slopes(points.size(), 6);
  for (int k = 0; k < 6; ++k) {
    constexpr double kStep = 1e-4;
    Parameters moved = at;
    moved[k] += k == 5 && at[5] > kMostRatio - kStep ? -kStep : kStep;
    const std::vector<double> there = distances_of(outline_of(moved), points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      slopes(static_cast<Eigen::Index>(i), k) = (there[i] - out.distances_mm[i]) / (moved[k] - at[k]);
    }
  }
  const auto count = static_cast<Eigen::Index>(points.size());
  const Eigen::Map<const Eigen::VectorXd> w(weights.data(), count), r(out.distances_mm.data(), count);
  out.products = slopes.transpose() * w.asDiagonal() * slopes;
  out.right = slopes.transpose() * w.asDiagonal() * r;
  return out;
}

/// Damped Gauss–Newton steps with fixed weights. Returns whether the outline is better.
bool improve(PearOutline& outline, const std::vector<Vec2>& points, const std::vector<double>& weights) {
  constexpr int kSteps = 6;
  OutlineEquations here = equations_of(outline, points, weights);
  double damping = 1e-3;
  bool any = false;
  for (int step = 0; step < kSteps; ++step) {
    Mat6 damped = here.products;
    damped.diagonal() += damping * (here.products.diagonal() + Parameters::Constant(1e-6));
    const PearOutline next = outline_of(parameters_of(outline) - solve_ldlt(damped, here.right));
    const bool better =
        weighted_squares(distances_of(next, points), weights) < weighted_squares(here.distances_mm, weights);
    damping = better ? damping / 5 : damping * 5;
    if (!better) continue;
    any = true;
    outline = next;
    if (step + 1 < kSteps) here = equations_of(outline, points, weights);
  }
  return any;
}

/// The points' mean and main directions as a first outline, with the smaller circle on one side or the other.
PearOutline first_outline(const std::vector<Vec2>& points, bool reversed) {
  Vec2 mean = Vec2::Zero();
  for (const Vec2& p : points) mean += p / static_cast<double>(points.size());
  Mat2 spread = Mat2::Zero();
  for (const Vec2& p : points) spread += (p - mean) * (p - mean).transpose();
  const SymmetricEigen<2> axes = symmetric_eigen(Mat2(spread / static_cast<double>(points.size())));
  const Vec2 along = axes.vectors.col(1);
  // The variance of points around an ellipse is half of each squared semi-axis.
  const Vec2 half = (2 * axes.values.cwiseMax(1e-6)).cwiseSqrt();
  PearOutline out{.center_mm = mean,
                  .axis_rad = std::atan2(along.y(), along.x()) + (reversed ? std::numbers::pi : 0.0),
                  .height_mm = 2 * half.y(),
                  .radius_mm = half.x(),
                  .upper_ratio = 0.75};
  return outline_of(parameters_of(out));
}

}  // namespace

std::optional<FittedFace> fit_face(const BoneProbe& probe, const Rigid& start, const FitEffort& effort) {
  FittedFace face;
  face.bone_from_face = start;
  Vec2 moved = Vec2::Zero();
  for (int turn = 0; turn < effort.turns; ++turn) {
    if (!fit_step(probe, effort.directions, face, moved)) return std::nullopt;
    if (moved.x() < kRest_mm && moved.y() < kRest_rad) break;
  }
  return face;
}

double face_score(const FittedFace& face) {
  constexpr double kRmsWeight = 0.2, kSlimPenalty = 0.3, kRoughPenalty = 0.1;
  constexpr double kSlimmest = 1.9;  // height over width; 1.3 to 1.5 is usual
  const double size_mm = face.fit.outline.height_mm;
  const FaceSurface& surface = face.surface;
  const bool like_a_head =
      surface.spherical && !surface.concave && 1 / surface.sphere->radius_mm > kMostConvexity_per_mm;
  if (size_mm < kLeastHeight_mm || size_mm > kMostHeight_mm || like_a_head) return -1;
  return face.rim_fraction() - kRmsWeight * face.fit.rms_mm -
         (size_mm > kSlimmest * 2 * face.fit.outline.radius_mm ? kSlimPenalty : 0) -
         (face.normal == FaceNormal::rim ? kRoughPenalty : 0);
}

std::vector<Vec3> FittedFace::rim_at_outline_mm() const {
  std::vector<Vec3> out;
  std::ranges::copy_if(rim_mm, std::back_inserter(out), [&](const Vec3& p) {
    return std::abs(fit.outline.distance_mm(p.head<2>())) <= 2 * kRimInlier_mm;
  });
  return out;
}

double PearOutline::distance_mm(const Vec2& point_mm, const Vec2& axis) const {
  const Vec2 from = point_mm - center_mm;
  const double along = from.dot(axis), across = from.x() * axis.y() - from.y() * axis.x();
  return implicit::pear(across, along, radius_mm - height_mm / 2, radius_mm, height_mm / 2 - upper_ratio * radius_mm,
                        upper_ratio * radius_mm);
}

std::optional<OutlineFit> fit_pear(const std::vector<Vec2>& rim_mm) {
  if (rim_mm.size() < kLeastPoints) return std::nullopt;
  constexpr int kRounds = 8;
  std::optional<OutlineFit> best;
  for (const bool reversed : {false, true}) {
    PearOutline outline = first_outline(rim_mm, reversed);
    bool better = true;
    for (int round = 0; round < kRounds && better; ++round) {
      better = improve(outline, rim_mm, weights_of(distances_of(outline, rim_mm)));
    }
    OutlineFit found{.outline = outline, .inlier_fraction = 0, .rms_mm = 0};
    for (const double r : distances_of(outline, rim_mm)) {
      if (std::abs(r) > kRimInlier_mm) continue;
      found.inlier_fraction += 1;
      found.rms_mm += r * r;
    }
    found.rms_mm = std::sqrt(found.rms_mm / std::max(1.0, found.inlier_fraction));
    found.inlier_fraction /= static_cast<double>(rim_mm.size());
    const auto cost = [](const OutlineFit& f) { return f.rms_mm - 2 * f.inlier_fraction; };
    if (!best || cost(found) < cost(*best)) best = found;
  }
  return best;
}

}  // namespace reamsim
