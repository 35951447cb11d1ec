#include "sim/bone/implicit.h"

#include <utility>

namespace reamsim::implicit {

double pear(double x, double y, double low_y, double low_radius, double high_y, double high_radius) {
  const double across = std::abs(x);
  const double up = y - low_y;
  const double height = high_y - low_y;
  const double sine = (low_radius - high_radius) / height;  // of the angle between the tangents and the axis
  const double cosine = std::sqrt(std::max(1 - sine * sine, 0.0));
  const double along = cosine * up - sine * across;
  if (along < 0) return std::hypot(across, up) - low_radius;
  if (along > cosine * height) return std::hypot(across, up - height) - high_radius;
  return cosine * across + sine * up - low_radius;
}

double tapered_rod(const Vec3& point, const Vec3& a, double radius_a, const Vec3& b, double radius_b) {
  const Vec3 axis = b - a;
  const double fraction = std::clamp((point - a).dot(axis) / axis.squaredNorm(), 0.0, 1.0);
  return (point - a - fraction * axis).norm() - (radius_a + fraction * (radius_b - radius_a));
}

double polygon(const Vec2& point, const std::vector<Vec2>& corners) {
  double nearest2 = (point - corners[0]).squaredNorm();
  bool inside = false;
  for (std::size_t i = 0, j = corners.size() - 1; i < corners.size(); j = i++) {
    const Vec2 edge = corners[j] - corners[i];
    const Vec2 from = point - corners[i];
    const double fraction = std::clamp(from.dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    nearest2 = std::min(nearest2, (from - fraction * edge).squaredNorm());
    const bool crosses = (corners[i].y() > point.y()) != (corners[j].y() > point.y());
    if (crosses && from.x() < edge.x() * from.y() / edge.y()) inside = !inside;
  }
  return (inside ? -1 : 1) * std::sqrt(nearest2);
}

}  // namespace reamsim::implicit
