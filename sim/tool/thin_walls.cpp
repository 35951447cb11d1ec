#include "sim/tool/thin_walls.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <vector>

#include "sim/tool/triangle_box.h"

namespace reamsim {

namespace {

/// A ray starts this share of its length below the surface, so that it does not meet the face that it comes from.
constexpr double kSkin = 1e-3;

using Triangle = std::array<Vec3, 3>;

/// Triangles by the cells of a cubic lattice that they pass through.
class TriangleCells {
 public:
  TriangleCells(const std::vector<Triangle>& triangles, double cell_mm) : triangles_(triangles), cell_mm_(cell_mm) {
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const auto& [a, b, c] = triangles[t];
      each_cell(a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c), [&](const Vec3i& cell) {
        const Vec3 center = cell_mm_ * (cell.cast<double>().array() + 0.5).matrix();
        if (!triangle_touches_box(a, b, c, center, Vec3::Constant(0.5 * cell_mm_ * (1 + kSkin)))) return;
        cells_[key(cell)].push_back(t);
      });
    }
  }

  /// The nearest triangle that the ray from `from` along the unit vector `along` meets within `length_mm`, and how far
  /// away; `length_mm` where it meets none.
  struct Hit {
    double way_mm;
    std::size_t triangle = 0;
  };
  [[nodiscard]] Hit first_hit(const Vec3& from, const Vec3& along, double length_mm) const {
    Hit hit{length_mm};
    const Vec3 end = from + length_mm * along;
    each_cell(from.cwiseMin(end), from.cwiseMax(end), [&](const Vec3i& cell) {
      const auto found = cells_.find(key(cell));
      if (found == cells_.end()) return;
      for (const std::size_t t : found->second) {
        const double way = way_to(triangles_[t], from, along);
        if (way < hit.way_mm) hit = {way, t};
      }
    });
    return hit;
  }

 private:
  template <typename Body>
  void each_cell(const Vec3& low, const Vec3& high, const Body& body) const {
    const Vec3i first = (low / cell_mm_).array().floor().cast<int>(),
                last = (high / cell_mm_).array().floor().cast<int>();
    Vec3i cell;
    for (cell.z() = first.z(); cell.z() <= last.z(); ++cell.z())
      for (cell.y() = first.y(); cell.y() <= last.y(); ++cell.y())
        for (cell.x() = first.x(); cell.x() <= last.x(); ++cell.x()) body(cell);
  }

  static std::uint64_t key(const Vec3i& cell) {
    constexpr std::int64_t kMiddle = 1 << 20;
    const auto at = [&](int i) { return static_cast<std::uint64_t>(cell[i] + kMiddle); };
    return at(0) | at(1) << 21 | at(2) << 42;
  }

  /// Along the ray to the triangle (Möller and Trumbore 1997); infinite where it passes by.
  static double way_to(const Triangle& t, const Vec3& from, const Vec3& along) {
    constexpr double kNever = std::numeric_limits<double>::infinity();
    const Vec3 ab = t[1] - t[0], ac = t[2] - t[0], p = along.cross(ac);
    const double determinant = ab.dot(p);
    if (determinant == 0) return kNever;
    const Vec3 s = from - t[0], q = s.cross(ab);
    const double u = s.dot(p) / determinant, v = along.dot(q) / determinant, way = ac.dot(q) / determinant;
    return u >= 0 && v >= 0 && u + v <= 1 && way > 0 ? way : kNever;
  }

  const std::vector<Triangle>& triangles_;
  double cell_mm_;
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> cells_;
};

Vec3 normal_of(const Triangle& t) {
  return (t[1] - t[0]).cross(t[2] - t[0]).normalized();
}

std::vector<Triangle> triangles_of(const TriangleMesh& mesh) {
  std::vector<Triangle> out;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Triangle t{mesh.vertices[static_cast<std::size_t>(a)], mesh.vertices[static_cast<std::size_t>(b)],
                     mesh.vertices[static_cast<std::size_t>(c)]};
    if (normal_of(t).norm() > 0.5) out.push_back(t);  // no area, no normal
  }
  return out;
}

/// Middles of the parts that the triangle falls into when its edges are divided into pieces of `step_mm` at most.
template <typename Body>
void each_point(const Triangle& t, double step_mm, const Body& body) {
  const double longest = std::max({(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()});
  const int parts = std::max(1, static_cast<int>(std::ceil(longest / step_mm)));
  for (int i = 0; i < parts; ++i) {
    for (int j = 0; i + j < parts; ++j) {
      const double u = (i + 1.0 / 3) / parts, v = (j + 1.0 / 3) / parts;
      body(Vec3(t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0])));
    }
  }
}

void keep_thinner(double thickness_mm, const Vec3& at, std::optional<ThinWall>& thinnest) {
  if (!thinnest || thickness_mm < thinnest->thickness_mm) thinnest = {thickness_mm, at};
}

struct Side {
  Vec2 begin, end, normal;
};

/// The profile's edges off the axis, and those of its other half.
std::vector<Side> sides_of(const Profile& profile) {
  std::vector<Side> sides;
  for (std::size_t i = 0; i < profile.points.size(); ++i) {
    const Vec2 &a = profile.points[i], &b = profile.points[(i + 1) % profile.points.size()];
    if (a == b || (Profile::on_axis(a) && Profile::on_axis(b))) continue;
    const Vec2 along = (b - a).normalized();
    sides.push_back({a, b, {along.y(), -along.x()}});
  }
  const std::size_t half = sides.size();
  for (std::size_t i = 0; i < half; ++i) {
    const auto mirrored = [](const Vec2& v) { return Vec2(-v.x(), v.y()); };
    sides.push_back({mirrored(sides[i].begin), mirrored(sides[i].end), mirrored(sides[i].normal)});
  }
  return sides;
}

/// The nearest side that the ray meets within `length_mm`; none: nullptr.
const Side* first_side(const std::vector<Side>& sides, const Vec2& from, const Vec2& along, double length_mm,
                       double& way_mm) {
  const Side* first = nullptr;
  way_mm = length_mm;
  for (const Side& side : sides) {
    const Vec2 edge = side.end - side.begin, to = side.begin - from;
    const double cross = along.x() * edge.y() - along.y() * edge.x();
    if (cross == 0) continue;
    const double way = (to.x() * edge.y() - to.y() * edge.x()) / cross;
    const double share = (to.x() * along.y() - to.y() * along.x()) / cross;
    if (way <= 0 || way >= way_mm || share < 0 || share > 1) continue;
    way_mm = way;
    first = &side;
  }
  return first;
}

}  // namespace

std::optional<ThinWall> thinnest_wall(const TriangleMesh& mesh, double limit_mm) {
  const std::vector<Triangle> triangles = triangles_of(mesh);
  const TriangleCells cells(triangles, limit_mm);
  const double skin = kSkin * limit_mm;
  std::optional<ThinWall> thinnest;
  for (const Triangle& t : triangles) {
    const Vec3 normal = normal_of(t);
    each_point(t, 0.5 * limit_mm, [&](const Vec3& at) {
      const auto hit = cells.first_hit(at - skin * normal, -normal, limit_mm - skin);
      if (hit.way_mm >= limit_mm - skin) return;
      if (normal_of(triangles[hit.triangle]).dot(normal) > -std::cos(kWallAngle)) return;
      keep_thinner(hit.way_mm + skin, at, thinnest);
    });
  }
  return thinnest;
}

std::optional<ThinWall> thinnest_wall(const Profile& profile, double limit_mm) {
  const std::vector<Side> sides = sides_of(profile);
  const double skin = kSkin * limit_mm;
  std::optional<ThinWall> thinnest;
  for (std::size_t i = 0; i < sides.size() / 2; ++i) {
    const Side& side = sides[i];
    const int parts = std::max(1, static_cast<int>(std::ceil((side.end - side.begin).norm() / (0.5 * limit_mm))));
    for (int k = 0; k < parts; ++k) {
      const Vec2 at = side.begin + (k + 0.5) / parts * (side.end - side.begin);
      double way = 0;
      const Side* other = first_side(sides, at - skin * side.normal, -side.normal, limit_mm - skin, way);
      if (other == nullptr || other->normal.dot(side.normal) > -std::cos(kWallAngle)) continue;
      keep_thinner(way + skin, {at.x(), 0, at.y()}, thinnest);
    }
  }
  return thinnest;
}

}  // namespace reamsim
