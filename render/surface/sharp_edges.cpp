// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "kernels/bone_face.h"
#include "render/surface/bone_surface.h"
#include "sim/base/parallel.h"

namespace reamsim {
namespace {

// Lengths in voxels.
constexpr int kHalfColumn = 3;
constexpr double kMaxCurvature = 0.2;          // of a face; more is an edge
constexpr double kMaxShift = 1.5;              // of a vertex onto a face; twice as much to an edge
constexpr double kFitReach = 5.5;              // of the points to which the faces at an edge are fitted
constexpr double kEdgeAngle = 0.4;             // between faces that meet at an edge
constexpr double kSameFace = 0.87;             // least cosine between the normals of a face's points
constexpr double kMaxMisfit = 0.15;            // of a quadratic face
constexpr std::size_t kLeast = 4;              // points of a quadratic face
constexpr int kRings = 3;                      // of vertices around reamed bone
constexpr std::size_t kVerticesAtOnce = 4096;  // of a range, which marks vertices of the whole part

/// A point of the surface, in voxel index space.
struct SurfacePoint {
  Vec3 point, normal;
  double curvature = 0;
};

/// The surface where columns of voxels end, the height functions of the volume-of-fluid method (Cummins, Francois and
/// Kothe 2005, doi:10.1016/j.compstruc.2004.08.017).
class HeightFunctions {
 public:
  HeightFunctions(const BoneView& bone, const FillBricks& before) : bone_(bone), before_(before) {}

  /// The surface at a point near it, along an axis; nothing where three by three columns do not end on a smooth face,
  /// or end at the rim of the reamed area, unless `rim`.
  [[nodiscard]] std::optional<SurfacePoint> at(const Vec3& near, const Vec3& normal, bool rim) const {
    std::array<int, 3> axes{0, 1, 2};
    std::ranges::sort(axes, std::greater(), [&](int axis) { return std::abs(normal[axis]); });
    auto found = along(axes[0], normal[axes[0]] > 0 ? 1 : -1, near, rim);
    return found ? found : along(axes[1], normal[axes[1]] > 0 ? 1 : -1, near, rim);
  }
  /// Whether the 27 voxels about a point have as much bone as expected(centre) says: not at a rounded edge.
  template <class Expected>
  [[nodiscard]] bool agree(const Vec3& about, const Expected& expected) const {
    constexpr double kMost = 1.5;  // voxels; 2.6 at an edge of 90° rounded with a radius of 2
    const Vec3i middle = about.array().round().cast<int>();
    double more = 0;
    for_each_voxel(middle - Vec3i::Ones(), middle + Vec3i::Ones(),
                   [&](const Vec3i& voxel) { more += expected(voxel.cast<double>()) - fraction(voxel); });
    return std::abs(more) < kMost;
  }

 private:
  [[nodiscard]] double fraction(const Vec3i& voxel) const {
    if (!bone_.voxmap.grid.contains(voxel) || bone_.voxmap.grade.get(voxel) == 0) return 0;
    return static_cast<double>(bone_.fill.get(voxel)) / FillBricks::kWhole;
  }
  /// Whether both the bone's surface and the tool intersect a voxel.
  [[nodiscard]] bool at_rim(const Vec3i& voxel) const {
    if (!bone_.voxmap.grid.contains(voxel) || bone_.voxmap.grade.get(voxel) == 0) return false;
    const std::uint16_t before = before_.get(voxel), now = bone_.fill.get(voxel);
    return before < FillBricks::kWhole && now < before && now > 0;
  }
  /// The mean height of the surface over the cross-section of a column, between a whole voxel and air near `voxel`.
  [[nodiscard]] std::optional<double> height(const Vec3i& voxel, int axis, int outward, bool rim) const {
    const auto voxel_at = [&](int i) -> Vec3i { return voxel + outward * i * Vec3i::Unit(axis); };
    const auto fraction_at = [&](int i) { return fraction(voxel_at(i)); };
    constexpr double kRounding = 1e-3;
    int i = 0;
    for (; fraction_at(i) < 1 - kRounding; --i) {
      if (i == -kHalfColumn) return std::nullopt;
    }
    double sum = i + 0.5;
    for (double last = 1; last > kRounding; ++i) {
      const double next = fraction_at(i + 1);
      if (i == kHalfColumn || next > last + kRounding || (!rim && at_rim(voxel_at(i + 1)))) return std::nullopt;
      sum += last = next;
    }
    return voxel[axis] + outward * sum;
  }
  [[nodiscard]] std::optional<SurfacePoint> along(int axis, int outward, const Vec3& near, bool rim) const {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const Vec3i middle = near.array().round().cast<int>();
    Eigen::Matrix3d h;
    for (int i = 0; i < 9; ++i) {
      Vec3i voxel = middle;
      voxel[u] += i / 3 - 1;
      voxel[v] += i % 3 - 1;
      const std::optional<double> found = height(voxel, axis, outward, rim);
      if (!found) return std::nullopt;
      h(i / 3, i % 3) = *found;
    }
    const double slope_u = (h(2, 1) - h(0, 1)) / 2, slope_v = (h(1, 2) - h(1, 0)) / 2;
    const double uu = h(2, 1) - 2 * h(1, 1) + h(0, 1), vv = h(1, 2) - 2 * h(1, 1) + h(1, 0);
    const double uv = (h(2, 2) - h(2, 0) - h(0, 2) + h(0, 0)) / 4;
    const double du = near[u] - middle[u], dv = near[v] - middle[v];
    SurfacePoint out{near, Vec3::Zero(), std::max({std::abs(uu), std::abs(vv), std::abs(uv)})};
    out.curvature /= std::pow(1 + slope_u * slope_u + slope_v * slope_v, 1.5);
    // The mean over a square is 1/24 of the second derivatives above its middle.
    out.point[axis] = h(1, 1) - (uu + vv) / 24 + (slope_u + uu * du / 2 + uv * dv) * du + (slope_v + vv * dv / 2) * dv;
    out.normal[axis] = outward;
    out.normal[u] = -outward * (slope_u + uu * du + uv * dv);
    out.normal[v] = -outward * (slope_v + vv * dv + uv * du);
    out.normal.normalize();
    if (out.curvature > kMaxCurvature || std::abs(out.point[axis] - near[axis]) > kMaxShift) return std::nullopt;
    return out;
  }

  const BoneView& bone_;
  const FillBricks& before_;
};

/// A quadratic height over a plane.
class Face {
 public:
  /// Fits it to points and their normals, by least squares; a plane to few of them.
  Face(const std::vector<SurfacePoint>& points, const Vec3& origin, const Vec3& up) : origin_(origin) {
    axes_ << up.unitOrthogonal(), up.cross(up.unitOrthogonal()), up;
    Eigen::Matrix<double, Eigen::Dynamic, 6> terms(3 * points.size(), 6);
    Eigen::VectorXd values(3 * points.size());
    for (Eigen::Index i = 0; i < terms.rows(); i += 3) {
      const SurfacePoint& given = points[static_cast<std::size_t>(i) / 3];
      const Vec3 p = axes_.transpose() * (given.point - origin), n = axes_.transpose() * given.normal;
      terms.middleRows<3>(i) = terms_at(p);
      values.segment<3>(i) = Vec3(p.z(), -n.x() / n.z(), -n.y() / n.z());
    }
    const Eigen::Index used = points.size() < kLeast ? 3 : 6;
    coefficients_.setZero();
    coefficients_.head(used) = least_squares(terms.leftCols(used), values);
    misfit_ = std::sqrt((terms * coefficients_ - values).squaredNorm() / static_cast<double>(points.size()));
  }
  /// RMS of the distances from the points and the differences of the slopes.
  [[nodiscard]] double misfit() const { return misfit_; }
  /// The closest point, to first order.
  [[nodiscard]] SurfacePoint closest(const Vec3& to) const {
    const Vec3 p = axes_.transpose() * (to - origin_), height = terms_at(p) * coefficients_;
    const Vec3 up = Vec3(-height[1], -height[2], 1).normalized();
    return {to + (height[0] - p.z()) * up.z() * (axes_ * up), axes_ * up};
  }
  /// Positive outside.
  [[nodiscard]] double distance(const Vec3& from) const {
    const SurfacePoint foot = closest(from);
    return (from - foot.point).dot(foot.normal);
  }
  /// Of the voxel at a point, inside.
  [[nodiscard]] double fraction(const Vec3& voxel) const { return std::clamp(0.5 - distance(voxel), 0.0, 1.0); }

 private:
  /// Height and slopes at (x, y), by coefficient.
  static Eigen::Matrix<double, 3, 6> terms_at(const Vec3& p) {
    Eigen::Matrix<double, 3, 6> out;
    out << 1, p.x(), p.y(), p.x() * p.x(), p.x() * p.y(), p.y() * p.y(),  //
        0, 1, 0, 2 * p.x(), p.y(), 0,                                     //
        0, 0, 1, 0, p.x(), 2 * p.y();
    return out;
  }

  Vec3 origin_;
  Eigen::Matrix3d axes_;
  Eigen::Matrix<double, 6, 1> coefficients_;
  double misfit_;
};

/// The fraction of the voxel at `p` that is inside both faces, or, of concave bone, inside one of them.
double fraction_within(const Face& a, const Face& b, bool concave, const Vec3& p) {
  const auto inside = [&](const Face& face) {
    return static_cast<float>(concave ? 1 - face.fraction(p) : face.fraction(p));
  };
  const auto cosine = static_cast<float>(a.closest(p).normal.dot(b.closest(p).normal));
  const FaceCut cut = rs_face_cut_at(inside(a), 1, cosine);
  const float both = rs_kept_fraction(&cut, inside(b));
  return concave ? 1 - both : both;
}

/// The point near `start` where two faces meet, closest to it.
Vec3 meeting(const Face& a, const Face& b, const Vec3& start) {
  constexpr int kSteps = 5;
  Vec3 out = start;
  for (int i = 0; i < kSteps; ++i) {
    const SurfacePoint on_a = a.closest(out), on_b = b.closest(out);
    const Vec3 along = on_a.normal.cross(on_b.normal).normalized();
    Eigen::Matrix3d planes;
    planes << on_a.normal.transpose(), on_b.normal.transpose(), along.transpose();
    const Vec3 off(on_a.normal.dot(on_a.point - out), on_b.normal.dot(on_b.point - out), along.dot(start - out));
    out += solve_three(planes, off);
  }
  return out;
}

/// Target positions of a vertex: on its face, and on the nearby edge.
struct Target {
  std::optional<SurfacePoint> face;
  std::optional<Vec3> edge;
};

/// The target of a vertex, given the points of the faces around it, the closest first; none if the fill disagrees.
Target target_of(const Vec3& vertex, const std::vector<SurfacePoint>& around, const HeightFunctions& heights) {
  if (around.empty()) return {};
  const SurfacePoint& first = around[0];
  const auto other = std::ranges::find_if(around, [&](const SurfacePoint& p) {
    const double bend = std::min(first.curvature, p.curvature) * (p.point - first.point).norm();
    return std::acos(std::clamp(p.normal.dot(first.normal), -1.0, 1.0)) > kEdgeAngle + bend;
  });
  const bool edge = other != around.end();
  std::array<std::vector<SurfacePoint>, 2> parts;
  for (const SurfacePoint& p : around) {
    const double to_first = p.normal.dot(first.normal), to_other = edge ? p.normal.dot(other->normal) : -1;
    if (std::max(to_first, to_other) > kSameFace) parts[to_first >= to_other ? 0 : 1].push_back(p);
  }
  const auto face_through = [&](const std::vector<SurfacePoint>& part, const SurfacePoint& closest) {
    const Face fitted(part, vertex, closest.normal);
    return fitted.misfit() < kMaxMisfit ? fitted : Face({closest}, vertex, closest.normal);
  };
  const Face a = face_through(parts[0], first);
  const SurfacePoint on_a = a.closest(vertex);
  const auto onto_a = [&] {
    return heights.agree(on_a.point, [&](const Vec3& p) { return a.fraction(p); }) ? Target{on_a, {}} : Target{};
  };
  if (!edge) return onto_a();
  const Face b = face_through(parts[1], *other);
  const Vec3 edge_point = meeting(a, b, vertex);
  if (!((edge_point - vertex).norm() < 2 * kMaxShift)) return onto_a();  // or it is NaN
  double side = 0;                                                       // negative: convex bone
  for (const SurfacePoint& p : parts[1]) side += a.distance(p.point);
  const auto expected = [&](const Vec3& p) { return fraction_within(a, b, side >= 0, p); };
  const SurfacePoint on_b = b.closest(vertex);
  const bool is_a = b.distance(on_a.point) * side >= 0, is_b = a.distance(on_b.point) * side >= 0;
  const bool a_is_closer = (on_a.point - vertex).norm() < (on_b.point - vertex).norm();
  Target out{(is_a && (a_is_closer || !is_b)) ? on_a : on_b, edge_point};
  if (!is_a && !is_b) out.face->point = edge_point;
  return heights.agree(edge_point, expected) && heights.agree(out.face->point, expected) ? out : Target{};
}

/// A part of a mesh in voxel index space while its vertices move.
struct MovingMesh {
  const std::vector<MeshTriangle>& triangles;
  const Neighbours& neighbours;
  std::vector<Vec3> points;

  /// Normal of a triangle times twice its area.
  static Vec3 area(const MeshTriangle& t, const std::vector<Vec3>& at) {
    return (at[t[1]] - at[t[0]]).cross(at[t[2]] - at[t[0]]);
  }
  /// The faces at the vertices within kFitReach of one, along the surface. `marks`: one per vertex, UINT32_MAX or
  /// from calls for other vertices.
  [[nodiscard]] std::vector<SurfacePoint> faces_around(std::uint32_t vertex, const std::vector<Target>& targets,
                                                       std::vector<std::uint32_t>& marks) const {
    std::vector<std::uint32_t> found{vertex};
    marks[vertex] = vertex;
    std::vector<SurfacePoint> out;
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (targets[found[i]].face) out.push_back(*targets[found[i]].face);
      for (const std::uint32_t next : neighbours.of(found[i])) {
        if (marks[next] == vertex || (points[next] - points[vertex]).norm() >= kFitReach) continue;
        marks[next] = vertex;
        found.push_back(next);
      }
    }
    std::ranges::stable_sort(out, {}, [&](const auto& p) { return (p.point - points[vertex]).squaredNorm(); });
    return out;
  }
  /// The vertex positions after the move. If two neighbours lie on different faces, the one closer to the edge moves to
  /// the edge, so that no triangle cuts the edge off. Corners of triangles that would turn over move to the mean of
  /// their neighbours, or stay.
  [[nodiscard]] std::vector<Vec3> moved(const std::vector<Target>& targets) const {
    std::vector<Vec3> out = points;
    const auto from_edge = [&](const Target& t) { return t.edge ? (*t.edge - t.face->point).norm() : 1e9; };
    for (std::size_t i = 0; i < out.size(); ++i) {
      const Target& own = targets[i];
      if (!own.face) continue;
      const auto is_across = [&](std::uint32_t next) {
        const Target& its = targets[next];
        return its.face && own.face->normal.dot(its.face->normal) < std::cos(kEdgeAngle) &&
               std::pair(from_edge(own), i) < std::pair(from_edge(its), std::size_t{next});
      };
      const bool to_edge = own.edge && std::ranges::any_of(neighbours.of(i), is_across);
      const Vec3& to = to_edge ? *own.edge : own.face->point;
      if ((to - points[i]).norm() < 2 * kMaxShift) out[i] = to;
    }
    constexpr int kRounds = 4;  // of means; one that turns another triangle is moved again
    bool turned = true;
    for (int round = 0; turned; ++round) {
      turned = false;
      const std::vector<Vec3> before = out;
      for (const MeshTriangle& t : triangles) {
        const bool is_moved = std::ranges::any_of(t, [&](std::int32_t i) { return before[i] != points[i]; });
        if (!is_moved || area(t, before).dot(area(t, points)) > 0) continue;
        turned = true;
        for (const std::int32_t corner : t) {
          Vec3 sum = Vec3::Zero();
          for (const std::uint32_t next : neighbours.of(corner)) sum += before[next];
          out[corner] = round < kRounds ? sum / static_cast<double>(neighbours.of(corner).size()) : points[corner];
        }
      }
    }
    return out;
  }
};

/// The vertices within kRings triangles of removed bone. `points` in voxel index space.
std::vector<std::uint8_t> near_reaming(const TriangleMesh& mesh, const std::vector<Vec3>& points, const BoneView& bone,
                                       const FillBricks& before) {
  std::vector<std::uint8_t> near(points.size(), 0);
  parallel_items(points.size(), [&](std::size_t i) {
    const Vec3i first = points[i].array().floor().cast<int>();
    for_each_voxel(first, first + Vec3i::Ones(), [&](const Vec3i& voxel) {
      if (bone.voxmap.grid.contains(voxel) && bone.fill.get(voxel) < before.get(voxel)) near[i] = 1;
    });
  });
  for (int ring = 0; ring < kRings; ++ring) {
    const std::vector<std::uint8_t> inner = near;
    for (const MeshTriangle& t : mesh.triangles) {
      if (inner[t[0]] == 0 && inner[t[1]] == 0 && inner[t[2]] == 0) continue;
      for (const std::int32_t corner : t) near[corner] = 1;
    }
  }
  return near;
}

}  // namespace

void sharpen_edges(TriangleMesh& mesh, const BoneView& bone, const UnreamedSurface& unreamed) {
  const VoxelGrid& grid = bone.voxmap.grid;
  std::vector<Vec3> all;
  for (const Vec3& p : mesh.vertices) all.emplace_back((p - grid.origin_mm) / grid.voxel_mm - Vec3::Constant(0.5));
  const std::vector<std::uint8_t> near = near_reaming(mesh, all, bone, unreamed.before);
  std::vector<std::size_t> vertices;  // of the part
  std::vector<std::int32_t> slots(all.size(), -1);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (near[i] == 0) continue;
    slots[i] = static_cast<std::int32_t>(points.size());
    vertices.push_back(i);
    points.push_back(all[i]);
  }
  std::vector<MeshTriangle> triangles;
  std::vector<std::uint32_t> corners;
  std::vector<Vec3> normals(points.size(), Vec3::Zero());
  for (const MeshTriangle& whole : mesh.triangles) {
    const MeshTriangle t{slots[whole[0]], slots[whole[1]], slots[whole[2]]};
    if (std::ranges::min(t) < 0) continue;
    triangles.push_back(t);
    corners.insert(corners.end(), t.begin(), t.end());
    for (const std::int32_t corner : t) normals[corner] += MovingMesh::area(t, points);
  }
  const Neighbours neighbours(points.size(), corners);
  const MovingMesh moving{triangles, neighbours, points};
  const HeightFunctions heights(bone, unreamed.before);
  std::vector<Target> smooth(points.size());
  parallel_items(points.size(),
                 [&](std::size_t i) { smooth[i].face = heights.at(points[i], normals[i].normalized(), false); });
  std::vector<Target> targets = smooth;
  parallel_ranges(points.size(), kVerticesAtOnce, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> marks;
    for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) {
      if (smooth[i].face) continue;
      marks.resize(points.size(), UINT32_MAX);
      targets[i] = target_of(points[i], moving.faces_around(i, smooth, marks), heights);
    }
  });
  // On rough bone, as from a CT, a quarter of the vertices at edges have no target, and the others would make it
  // ragged.
  const auto none = [](const Target& target) { return !target.face; };
  if (10 * std::ranges::count_if(targets, none) > std::ranges::count_if(smooth, none)) targets = smooth;
  parallel_items(points.size(), [&](std::size_t i) {
    if (!targets[i].face) targets[i].face = heights.at(points[i], normals[i].normalized(), true);
  });
  const std::vector<Vec3> moved = moving.moved(targets);
  for (std::size_t i = 0; i < moved.size(); ++i) {
    if (moved[i] == points[i]) continue;
    mesh.vertices[vertices[i]] = grid.origin_mm + grid.voxel_mm * (moved[i] + Vec3::Constant(0.5));
  }
}

}  // namespace reamsim
