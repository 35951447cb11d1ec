// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "sim/base/statistics.h"
#include "sim/scan/ct_import.h"

namespace reamsim::ct {

namespace {

constexpr double kReach_mm = 75;  // of the surface points from the given point
constexpr int kLeastRadius_mm = 16, kMostRadius_mm = 32;
constexpr double kCell_mm = 2;  // of the votes
/// Distance of the point from the surface of the head, negative inside.
constexpr double kNearest_mm = -9, kFarthest_mm = 12;
constexpr double kLeastSlope_hu_mm = 40;  // of the surface of bone
constexpr double kFacing = 0.85;          // cosine between the surface's normal and the way from the centre
constexpr double kLeastSupport = 0.4;     // of the area of the sphere
constexpr double kOnHead_mm = 1.5;        // from the sphere
constexpr double kVoteCell_mm = 3;        // of the votes in a whole scan

constexpr double kGlenoid = 28 * std::numbers::pi / 180;  // half of the angle under which the head sees it

struct SurfacePoint {
  Vec3 place_mm;
  Vec3 outward;
};

/// The surface of all bone in a box of voxels; of every `step`-th voxel along each axis.
std::vector<SurfacePoint> surface_in(const AlignedImage& hu, double threshold_hu, const Vec3i& first, const Vec3i& last,
                                     int step = 1) {
  if ((first.array() > last.array()).any()) return {};
  std::vector<SurfacePoint> out;
  const auto dense = [&](const Vec3i& v) { return double{hu.at(v)} >= threshold_hu; };
  for_each_voxel(Vec3i::Zero(), (last - first) / step, [&](const Vec3i& at) {
    const Vec3i voxel = first + step * at;
    const auto dense_beside = [&](const Vec3i& side) { return dense(voxel + side); };
    if (!dense(voxel) || std::ranges::all_of(kFaceSteps, dense_beside)) return;
    const Vec3 slope = hu.gradient(voxel);
    if (slope.norm() < kLeastSlope_hu_mm) return;
    // The surface passes between this voxel and the next.
    const Vec3 outward = -slope.normalized();
    const double beyond_mm =
        std::min((double{hu.at(voxel)} - threshold_hu) / slope.norm(), hu.lattice.spacing_mm.norm() / 2);
    out.push_back({hu.lattice.center_mm(voxel) + beyond_mm * outward, outward});
  });
  return out;
}

/// The surface of all bone near a point.
std::vector<SurfacePoint> surface_round(const AlignedImage& hu, double threshold_hu, const Vec3& point_mm,
                                        double reach_mm) {
  const Lattice& lattice = hu.lattice;
  const Vec3i first = lattice.voxel_of(point_mm - Vec3::Constant(reach_mm)).cwiseMax(1);
  const Vec3i last = lattice.voxel_of(point_mm + Vec3::Constant(reach_mm)).cwiseMin(lattice.dims - Vec3i::Constant(2));
  return surface_in(hu, threshold_hu, first, last);
}

bool may_face(const Sphere& sphere, const Vec3& near_mm) {
  const double away_mm = (near_mm - sphere.center_mm).norm() - sphere.radius_mm;
  return away_mm >= kNearest_mm && away_mm <= kFarthest_mm;
}

/// Surface points vote for the cell of the centre of their sphere. Calls use(cell, votes) for the cells that have
/// votes, with those of their neighbours.
template <class CellOf, class Use>
void vote(const std::vector<SurfacePoint>& surface, int radius_mm, const Vec3i& cells, const CellOf& cell_of,
          const Use& use) {
  std::vector<float> votes(static_cast<std::size_t>(cells.cast<std::int64_t>().prod()));
  for (const SurfacePoint& p : surface) {
    const Vec3i cell = cell_of(Vec3(p.place_mm - radius_mm * p.outward));
    if ((cell.array() >= 1).all() && (cell.array() < cells.array() - 1).all()) votes[index_in(cells, cell)] += 1;
  }
  for_each_voxel(Vec3i::Ones(), cells - Vec3i::Constant(2), [&](const Vec3i& cell) {
    if (votes[index_in(cells, cell)] == 0) return;
    double sum = 0;
    for_each_voxel(Vec3i::Constant(-1), Vec3i::Constant(1),
                   [&](const Vec3i& d) { sum += double{votes[index_in(cells, cell + d)]}; });
    use(cell, sum);
  });
}

/// The centre and radius with the most votes for their area.
Sphere most_votes(const std::vector<SurfacePoint>& surface, const Vec3& near_mm) {
  constexpr int kHalf = static_cast<int>((kMostRadius_mm + kFarthest_mm) / kCell_mm) + 1;
  const Vec3i middle = Vec3i::Constant(kHalf);
  Sphere best;
  double most = 0;
  for (int radius = kLeastRadius_mm; radius <= kMostRadius_mm; ++radius) {
    const auto cell_of = [&](const Vec3& center) -> Vec3i {
      if (!may_face({center, double(radius)}, near_mm)) return Vec3i::Zero();  // at the edge, where no vote counts
      return middle + ((center - near_mm) / kCell_mm).array().round().cast<int>().matrix();
    };
    vote(surface, radius, 2 * middle + Vec3i::Ones(), cell_of, [&](const Vec3i& cell, double votes) {
      if (votes / radius <= most) return;
      most = votes / radius;
      best = {near_mm + kCell_mm * (cell - middle).cast<double>(), double(radius)};
    });
  }
  return best;
}

std::vector<Vec3> points_on(const std::vector<SurfacePoint>& surface, const Sphere& sphere, double within_mm) {
  std::vector<Vec3> out;
  for (const SurfacePoint& p : surface) {
    const Vec3 way = p.place_mm - sphere.center_mm;
    const double distance = way.norm();
    if (std::abs(distance - sphere.radius_mm) < within_mm && way.dot(p.outward) > kFacing * distance) {
      out.push_back(p.place_mm);
    }
  }
  return out;
}

/// Gauss–Newton steps on the distances of the points near the sphere, ever nearer.
Sphere refined(const std::vector<SurfacePoint>& surface, Sphere sphere) {
  for (const double within_mm : {4.0, 4.0, 3.0, 3.0, 2.0, 2.0, 1.5, 1.5, 1.5, 1.5}) {
    Mat4 products = 1e-9 * Mat4::Identity();
    Vec4 right = Vec4::Zero();
    for (const Vec3& p : points_on(surface, sphere, within_mm)) {
      const Vec3 way = p - sphere.center_mm;
      const Vec3 unit = way.normalized();
      const Vec4 row(unit.x(), unit.y(), unit.z(), 1);
      products += row * row.transpose();
      right += (way.norm() - sphere.radius_mm) * row;
    }
    const Vec4 step = solve_ldlt(products, right);
    sphere.center_mm += step.head<3>();
    sphere.radius_mm += step.w();
  }
  return sphere;
}

/// `count` directions within an angle of an axis, equally dense.
std::vector<Vec3> directions_towards(const Vec3& axis, double half_angle, int count) {
  const Vec3 x = axis.unitOrthogonal(), y = axis.cross(x);
  std::vector<Vec3> out;
  for (int n = 0; n < count; ++n) {  // equal areas of the cap, by the golden angle
    const double cosine = 1 - (1 - std::cos(half_angle)) * (n + 0.5) / count;
    const double angle = n * std::numbers::pi * (3 - std::sqrt(5.0)), sine = std::sqrt(1 - cosine * cosine);
    out.push_back(cosine * axis + sine * (std::cos(angle) * x + std::sin(angle) * y));
  }
  return out;
}

/// Where a line from the centre passes from the head to the glenoid: distance and value of the least radiodensity.
struct GapPoint {
  double at_mm = 0;
  double hu = 0;
};

/// nullopt where no bone follows within the widest gap.
std::optional<GapPoint> gap_on(const AlignedImage& hu, double threshold_hu, const Sphere& head, const Vec3& direction) {
  constexpr double kStep_mm = 0.25, kInside_mm = 3, kWidest_mm = 8;
  std::vector<double> values;
  const double from_mm = head.radius_mm - kInside_mm;
  for (double at = 0; at <= 2 * kInside_mm + kWidest_mm; at += kStep_mm) {
    const Vec3 point_mm = head.center_mm + (from_mm + at) * direction;
    const Vec3 place = (point_mm - hu.lattice.origin_mm).cwiseQuotient(hu.lattice.spacing_mm);
    values.push_back(interpolated(hu.value, hu.lattice.dims, place));
  }
  const auto plate_end = values.begin() + static_cast<std::ptrdiff_t>((kInside_mm + 1) / kStep_mm);
  const auto plate = std::max_element(values.begin(), plate_end);
  // The first bone behind a minimum.
  auto least = plate;
  for (auto it = plate; it != values.end(); ++it) {
    if (*it < *least) least = it;
    if (it > least && *it >= std::max(threshold_hu, *least + 50)) {
      return GapPoint{from_mm + kStep_mm * static_cast<double>(least - values.begin()), *least};
    }
  }
  return std::nullopt;
}

void choose_cut(const AlignedImage& hu, double threshold_hu, const Vec3& near_mm, HumeralHead& head) {
  std::vector<double> at_mm;
  double touching = 0;
  constexpr int kCount = 400;
  for (const Vec3& direction : directions_towards((near_mm - head.center_mm).normalized(), kGlenoid, kCount)) {
    const auto gap = gap_on(hu, threshold_hu, head, direction);
    if (!gap) continue;
    at_mm.push_back(gap->at_mm);
    touching += gap->hu >= threshold_hu ? 1 : 0;
  }
  head.cut_radius_mm = at_mm.empty() ? head.radius_mm + 1 : quantile(at_mm, 0.5);
  head.touching_fraction = at_mm.empty() ? 0 : touching / static_cast<double>(at_mm.size());
}

/// The spheres with the most votes in the whole scan, for their area; none near another.
std::vector<Sphere> sphere_peaks(const AlignedImage& hu, double threshold_hu) {
  constexpr std::size_t kMostPeaks = 12;
  constexpr int kRadiusStep_mm = 2;
  constexpr double kManyVoxels = 2e7;  // every second voxel of larger scans votes
  const int step = static_cast<double>(hu.lattice.size()) > kManyVoxels ? 2 : 1;
  const std::vector<SurfacePoint> surface =
      surface_in(hu, threshold_hu, Vec3i::Ones(), hu.lattice.dims - Vec3i::Constant(2), step);
  const Aabb box = hu.lattice.bounds_mm();
  const Vec3i cells = ((box.max - box.min) / kVoteCell_mm).array().ceil().cast<int>();
  struct Peak {
    double votes;
    Sphere sphere;
  };
  std::vector<Peak> peaks;
  const auto cell_of = [&](const Vec3& center) -> Vec3i {
    return ((center - box.min) / kVoteCell_mm).array().floor().cast<int>();
  };
  for (int radius = kLeastRadius_mm; radius <= kMostRadius_mm; radius += kRadiusStep_mm) {
    // A third of a sphere, of whose points half vote for a cell nearby.
    const double spacing_mm = step * std::cbrt(hu.lattice.voxel_mm3());
    const double whole = 4 * std::numbers::pi * radius * radius / (spacing_mm * spacing_mm);
    constexpr double kLeastVotes = 0.12;
    vote(surface, radius, cells, cell_of, [&](const Vec3i& cell, double sum) {
      if (sum < kLeastVotes * whole) return;
      const Vec3 center = box.min + kVoteCell_mm * (cell.cast<double>() + Vec3::Constant(0.5));
      peaks.push_back({sum / whole, {center, double(radius)}});
    });
  }
  std::ranges::stable_sort(peaks, std::greater(), &Peak::votes);
  std::vector<Sphere> out;
  for (const Peak& peak : peaks) {
    const auto near = [&](const Sphere& other) {
      return (other.center_mm - peak.sphere.center_mm).norm() < 0.5 * kLeastRadius_mm;
    };
    if (out.size() == kMostPeaks) break;
    if (std::none_of(out.begin(), out.end(), near)) out.push_back(peak.sphere);
  }
  return out;
}

/// Whether the surface of bone lies on the sphere in a direction.
bool meets_surface(const std::vector<Vec3>& ways, const Vec3& direction) {
  constexpr double kNear = 0.9962;  // cosine of 5 degrees
  return std::any_of(ways.begin(), ways.end(), [&](const Vec3& way) { return way.dot(direction) >= kNear; });
}

/// The joint of a head: the cap of the sphere behind whose surface a gap and more bone follow. nullopt where no cap of
/// the size of a glenoid does.
std::optional<Joint> joint_of(const AlignedImage& hu, double threshold_hu, const HumeralHead& head,
                              const std::vector<SurfacePoint>& surface) {
  constexpr int kDirections = 1200;
  constexpr double kLeastGap = 0.5;  // of the cap
  std::vector<Vec3> ways;
  for (const Vec3& p : points_on(surface, head, kOnHead_mm)) ways.push_back((p - head.center_mm).normalized());
  std::vector<Vec3> facing;
  std::vector<double> gap_mm;
  const std::vector<Vec3> all = directions_towards(Vec3::UnitZ(), std::numbers::pi, kDirections);
  for (const Vec3& direction : all) {
    if (!meets_surface(ways, direction)) continue;
    const auto gap = gap_on(hu, threshold_hu, head, direction);
    if (!gap) continue;
    facing.push_back(direction);
    gap_mm.push_back(gap->at_mm);
  }
  // The cap with the most of them; its mean lies nearer to the middle of the glenoid.
  Joint best{.head = head};
  const double full = kDirections * (1 - std::cos(kGlenoid)) / 2;
  for (const Vec3& axis : all) {
    Vec3 sum = Vec3::Zero();
    int count = 0;
    for (const Vec3& direction : facing) {
      if (direction.dot(axis) < std::cos(kGlenoid)) continue;
      sum += direction;
      ++count;
    }
    if (count / full <= best.gap_fraction) continue;
    best.gap_fraction = std::min(count / full, 1.0);
    best.near_mm = sum.normalized();
  }
  if (best.gap_fraction < kLeastGap) return std::nullopt;
  // A face larger than the cap holds it in many places: to the middle of the face.
  constexpr double kWider = 50 * std::numbers::pi / 180;
  constexpr int kTurns = 30;
  for (int turn = 0; turn < kTurns; ++turn) {
    Vec3 sum = Vec3::Zero();
    for (const Vec3& direction : facing) {
      if (direction.dot(best.near_mm) >= std::cos(kWider)) sum += direction;
    }
    best.near_mm = sum.normalized();
  }
  constexpr double kBehindGap_mm = 1;
  best.near_mm = head.center_mm + (quantile(gap_mm, 0.5) + kBehindGap_mm) * best.near_mm;
  return best;
}

/// Returns the fitted sphere as a head, or nullopt if the sphere is no head.
std::optional<HumeralHead> head_of(const AlignedImage& hu, const std::vector<SurfacePoint>& surface,
                                   const Sphere& sphere) {
  if (!(sphere.radius_mm >= kLeastRadius_mm && sphere.radius_mm <= kMostRadius_mm)) return std::nullopt;
  const std::vector<Vec3> on_head = points_on(surface, sphere, kOnHead_mm);
  const double voxel_mm2 = std::pow(hu.lattice.voxel_mm3(), 2.0 / 3);
  const double area_mm2 = 4 * std::numbers::pi * sphere.radius_mm * sphere.radius_mm;
  if (static_cast<double>(on_head.size()) * voxel_mm2 < kLeastSupport * area_mm2) return std::nullopt;
  HumeralHead out{sphere};
  double squares = 0;
  for (const Vec3& p : on_head) squares += std::pow((p - sphere.center_mm).norm() - sphere.radius_mm, 2);
  out.rms_mm = std::sqrt(squares / static_cast<double>(on_head.size()));
  return out;
}

}  // namespace

std::optional<HumeralHead> find_humeral_head(const AlignedImage& hu, double threshold_hu, const Vec3& near_mm) {
  const std::vector<SurfacePoint> surface = surface_round(hu, threshold_hu, near_mm, kReach_mm);
  const Sphere sphere = refined(surface, most_votes(surface, near_mm));
  if (!may_face(sphere, near_mm)) return std::nullopt;
  std::optional<HumeralHead> out = head_of(hu, surface, sphere);
  if (out) choose_cut(hu, threshold_hu, near_mm, *out);
  return out;
}

std::vector<Joint> find_joints(const AlignedImage& hu, double threshold_hu) {
  std::vector<Joint> out;
  for (const Sphere& voted : sphere_peaks(hu, threshold_hu)) {
    const std::vector<SurfacePoint> surface =
        surface_round(hu, threshold_hu, voted.center_mm, kMostRadius_mm + kVoteCell_mm);
    const auto head = head_of(hu, surface, refined(surface, voted));
    const auto known = [&](const Joint& joint) {
      return head && (joint.head.center_mm - head->center_mm).norm() < kLeastRadius_mm;
    };
    if (!head || std::any_of(out.begin(), out.end(), known)) continue;
    if (auto joint = joint_of(hu, threshold_hu, *head, surface)) out.push_back(*joint);
  }
  std::ranges::stable_sort(out, std::greater(), &Joint::gap_fraction);
  return out;
}

}  // namespace reamsim::ct
