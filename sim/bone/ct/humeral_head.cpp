#include "sim/bone/ct/humeral_head.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "sim/base/statistics.h"

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

struct SurfacePoint {
  Vec3 place_mm;
  Vec3 outward;
};

double value_at(const AlignedImage& hu, const Vec3& point_mm) {
  const Vec3 place = (point_mm - hu.lattice.origin_mm).cwiseQuotient(hu.lattice.spacing_mm);
  const Vec3 last = (hu.lattice.dims - Vec3i::Ones()).cast<double>();
  const Vec3 inside = place.cwiseMax(0).cwiseMin(last);
  const Vec3 base = inside.array().floor().min(last.array() - 1).max(0);
  double out = 0;
  for_each_trilinear_weight(inside - base, [&](const Vec3i& step, double weight) {
    out += weight * double{hu.at((base.cast<int>() + step).cwiseMin(hu.lattice.dims - Vec3i::Ones()))};
  });
  return out;
}

/// The surface of all bone near a point.
std::vector<SurfacePoint> surface_round(const AlignedImage& hu, double threshold_hu, const Vec3& near_mm) {
  const Lattice& lattice = hu.lattice;
  const Vec3i first = lattice.voxel_of(near_mm - Vec3::Constant(kReach_mm)).cwiseMax(1);
  const Vec3i last = lattice.voxel_of(near_mm + Vec3::Constant(kReach_mm)).cwiseMin(lattice.dims - Vec3i::Constant(2));
  std::vector<SurfacePoint> out;
  for_each_voxel(first, last, [&](const Vec3i& voxel) {
    const auto dense = [&](const Vec3i& v) { return double{hu.at(v)} >= threshold_hu; };
    if (!dense(voxel)) return;
    bool surface = false;
    for (int axis = 0; axis < 3; ++axis) {
      surface = surface || !dense(voxel + Vec3i::Unit(axis)) || !dense(voxel - Vec3i::Unit(axis));
    }
    if (!surface) return;
    const Vec3 slope = hu.gradient(voxel);
    if (slope.norm() < kLeastSlope_hu_mm) return;
    // The surface passes between this voxel and the next.
    const Vec3 outward = -slope.normalized();
    const double beyond_mm =
        std::min((double{hu.at(voxel)} - threshold_hu) / slope.norm(), lattice.spacing_mm.norm() / 2);
    out.push_back({lattice.center_mm(voxel) + beyond_mm * outward, outward});
  });
  return out;
}

struct Sphere {
  Vec3 center_mm = Vec3::Zero();
  double radius_mm = 0;
};

bool may_face(const Sphere& sphere, const Vec3& near_mm) {
  const double away_mm = (near_mm - sphere.center_mm).norm() - sphere.radius_mm;
  return away_mm >= kNearest_mm && away_mm <= kFarthest_mm;
}

/// The centre and radius with the most votes for their area.
Sphere most_votes(const std::vector<SurfacePoint>& surface, const Vec3& near_mm) {
  constexpr int kHalf = static_cast<int>((kMostRadius_mm + kFarthest_mm) / kCell_mm) + 1, kSide = 2 * kHalf + 1;
  const auto cells = static_cast<std::size_t>(kSide) * kSide * kSide;
  const auto index = [&](const Vec3i& c) {
    return static_cast<std::size_t>(c.x() + kHalf + kSide * (c.y() + kHalf + kSide * (c.z() + kHalf)));
  };
  std::vector<float> votes(cells);
  Sphere best;
  double most = 0;
  for (int radius = kLeastRadius_mm; radius <= kMostRadius_mm; ++radius) {
    std::fill(votes.begin(), votes.end(), 0.0F);
    for (const SurfacePoint& p : surface) {
      const Vec3 center = p.place_mm - radius * p.outward;
      if (!may_face({center, double(radius)}, near_mm)) continue;
      const Vec3i cell = ((center - near_mm) / kCell_mm).array().round().cast<int>();
      if (cell.cwiseAbs().maxCoeff() < kHalf) votes[index(cell)] += 1;
    }
    for_each_voxel(Vec3i::Constant(1 - kHalf), Vec3i::Constant(kHalf - 1), [&](const Vec3i& cell) {
      if (votes[index(cell)] == 0) return;
      double sum = 0;
      for_each_voxel(Vec3i::Constant(-1), Vec3i::Constant(1),
                     [&](const Vec3i& d) { sum += double{votes[index(cell + d)]}; });
      if (sum / radius <= most) return;
      most = sum / radius;
      best = {near_mm + kCell_mm * cell.cast<double>(), double(radius)};
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
    Eigen::Matrix4d products = 1e-9 * Eigen::Matrix4d::Identity();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    for (const Vec3& p : points_on(surface, sphere, within_mm)) {
      const Vec3 way = p - sphere.center_mm;
      const Vec3 unit = way.normalized();
      const Eigen::Vector4d row(unit.x(), unit.y(), unit.z(), 1);
      products += row * row.transpose();
      right += (way.norm() - sphere.radius_mm) * row;
    }
    const Eigen::Vector4d step = products.ldlt().solve(right);
    sphere.center_mm += step.head<3>();
    sphere.radius_mm += step.w();
  }
  return sphere;
}

/// Directions from the centre towards the glenoid.
std::vector<Vec3> directions_towards(const Vec3& axis) {
  constexpr double kHalfAngle = 28 * std::numbers::pi / 180;
  constexpr int kCount = 400;
  const Vec3 x = axis.unitOrthogonal(), y = axis.cross(x);
  std::vector<Vec3> out;
  for (int n = 0; n < kCount; ++n) {  // equal areas of the cap, by the golden angle
    const double cosine = 1 - (1 - std::cos(kHalfAngle)) * (n + 0.5) / kCount;
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
    values.push_back(value_at(hu, head.center_mm + (from_mm + at) * direction));
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
  const Sphere sphere{head.center_mm, head.radius_mm};
  std::vector<double> at_mm;
  double touching = 0;
  for (const Vec3& direction : directions_towards((near_mm - head.center_mm).normalized())) {
    const auto gap = gap_on(hu, threshold_hu, sphere, direction);
    if (!gap) continue;
    at_mm.push_back(gap->at_mm);
    touching += gap->hu >= threshold_hu ? 1 : 0;
  }
  head.cut_radius_mm = at_mm.empty() ? head.radius_mm + 1 : quantile(at_mm, 0.5);
  head.touching_fraction = at_mm.empty() ? 0 : touching / static_cast<double>(at_mm.size());
}

}  // namespace

std::optional<HumeralHead> find_humeral_head(const AlignedImage& hu, double threshold_hu, const Vec3& near_mm) {
  const std::vector<SurfacePoint> surface = surface_round(hu, threshold_hu, near_mm);
  const Sphere sphere = refined(surface, most_votes(surface, near_mm));
  const std::vector<Vec3> on_head = points_on(surface, sphere, 1.5);
  const double voxel_mm2 = std::pow(hu.lattice.voxel_mm3(), 2.0 / 3);
  const double area_mm2 = 4 * std::numbers::pi * sphere.radius_mm * sphere.radius_mm;
  const bool plausible = sphere.radius_mm >= kLeastRadius_mm && sphere.radius_mm <= kMostRadius_mm &&
                         may_face(sphere, near_mm) &&
                         static_cast<double>(on_head.size()) * voxel_mm2 >= kLeastSupport * area_mm2;
  if (!plausible) return std::nullopt;
  HumeralHead out{.center_mm = sphere.center_mm, .radius_mm = sphere.radius_mm};
  double squares = 0;
  for (const Vec3& p : on_head) squares += std::pow((p - sphere.center_mm).norm() - sphere.radius_mm, 2);
  out.rms_mm = std::sqrt(squares / static_cast<double>(on_head.size()));
  choose_cut(hu, threshold_hu, near_mm, out);
  return out;
}

}  // namespace reamsim::ct
