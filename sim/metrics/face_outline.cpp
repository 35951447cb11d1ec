#include "sim/metrics/face_outline.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/metrics/face_fit.h"

namespace reamsim {

namespace {

/// Middle of a polygon's area.
Vec2 middle_of(const std::vector<Vec2>& corners) {
  Vec2 sum = Vec2::Zero();
  double doubled_area = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2& a = corners[i];
    const Vec2& b = corners[(i + 1) % corners.size()];
    const double cross = a.x() * b.y() - a.y() * b.x();
    doubled_area += cross;
    sum += cross * (a + b) / 3;
  }
  return doubled_area == 0 ? Vec2(Vec2::Zero()) : Vec2(sum / doubled_area);
}

double distance_from_edge(const Vec2& place, const Vec2& a, const Vec2& b) {
  const Vec2 along = b - a;
  const double length2 = along.squaredNorm();
  const double at = length2 == 0 ? 0 : std::clamp((place - a).dot(along) / length2, 0.0, 1.0);
  return (place - a - at * along).norm();
}

}  // namespace

std::optional<FaceOutline> FaceOutline::of(const std::vector<Vec3>& rim_mm, const Vec3& outward) {
  const std::optional<PlaneFit> plane = fit_plane(rim_mm, outward);
  if (!plane) return std::nullopt;
  FaceOutline out;
  const Vec3 across = plane->normal.unitOrthogonal();
  out.bone_from_outline_.linear() << across, plane->normal.cross(across), plane->normal;
  out.bone_from_outline_.translation() = plane->point_mm;
  const auto to_corners = [&] {
    out.corners_mm_.clear();
    constexpr double kFar = std::numeric_limits<double>::infinity();
    out.box_mm_ = {Vec3::Constant(kFar), Vec3::Constant(-kFar)};
    const Rigid outline_from_bone = out.bone_from_outline_.inverse();
    for (const Vec3& point : rim_mm) {
      const Vec3 place = outline_from_bone * point;
      out.corners_mm_.emplace_back(place.head<2>());
      out.box_mm_.min = out.box_mm_.min.cwiseMin(place);
      out.box_mm_.max = out.box_mm_.max.cwiseMax(place);
    }
  };
  to_corners();
  const Vec2 middle = middle_of(out.corners_mm_);
  out.bone_from_outline_.translation() = out.bone_from_outline_ * Vec3(middle.x(), middle.y(), 0);
  to_corners();
  return out;
}

double FaceOutline::inside_mm(const Vec2& place) const {
  double distance = std::numeric_limits<double>::infinity();
  bool inside = false;
  for (std::size_t i = 0; i < corners_mm_.size(); ++i) {
    const Vec2& a = corners_mm_[i];
    const Vec2& b = corners_mm_[(i + 1) % corners_mm_.size()];
    distance = std::min(distance, distance_from_edge(place, a, b));
    const bool crosses = (a.y() > place.y()) != (b.y() > place.y()) &&
                         place.x() < a.x() + (place.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    inside ^= crosses;
  }
  return inside ? distance : -distance;
}

}  // namespace reamsim
