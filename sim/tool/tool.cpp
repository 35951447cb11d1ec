// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/tool.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <boost/functional/hash.hpp>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <utility>

#include "sim/bone/voxmap/voxmap.h"
#include "sim/mesh/mesh_io.h"

namespace reamsim {

namespace {

/// Largest shell spacing without missed voxels, in voxels (docs/erosion.md, 2).
constexpr double kSafeSpacingVoxels = 0.5;
/// Automatic spacing, in voxels: below the safe one, and no simple fraction of a voxel. At exactly half a voxel,
/// aligned with the lattice, all layers of points would enter their next layers of voxels in the same frame.
constexpr double kChosenSpacingVoxels = 0.4721;
constexpr int kGridResolution = 1024;  // limit of the automatic resolution of a shell without points
/// Relative tolerance of the spacing, for the rounding of coordinates in an STL.
constexpr double kSpacingSlack = 1e-6;
constexpr double kFacetCells = 0.02;  // tolerated sagitta of the revolved envelope's facets, cells
/// Distance of the centroid from the axis over the largest radius, beyond which the mesh is not in the tool frame.
constexpr double kOffAxisWarn = 0.01;
constexpr double kOffAxisError = 0.1;
/// Distance of the lowest point from z = 0 that is warned of, relative to the tool's height: a cannula can lift it.
constexpr double kOffOriginWarn = 0.1;
/// No cannula puts it below z = 0 by more than the rounding of a mesh.
constexpr double kBelowOriginWarn_mm = 0.01;

InputError tool_error(const ToolSettings& settings, const std::string& found, const std::string& expected) {
  return {SourceLocation{settings.mesh, 0, 0}, "tool.mesh", found, expected};
}

/// Centroid of the enclosed solid.
Vec3 centroid(const TriangleMesh& mesh) {
  Vec3 sum = Vec3::Zero();
  double volume6 = 0;
  for (const auto& t : mesh.triangles) {
    const auto [a, b, c] = mesh.corners(t);
    const double v = a.dot(b.cross(c));
    sum += v * (a + b + c) / 4;
    volume6 += v;
  }
  return sum / volume6;
}

/// The mesh must be in the tool frame: spin axis on z, cutting end at the origin.
void check_frame(const ToolSettings& settings, const TriangleMesh& mesh, const Profile& profile, Diagnostics& report) {
  const double off_axis = centroid(mesh).head<2>().norm();
  const std::string found = fmt::format("the mesh's centroid is {:.4g} mm off the z axis", off_axis);
  if (off_axis > kOffAxisError * profile.max_radius_mm())
    throw tool_error(settings, found, "place the spin axis on z, with +z towards the drive");
  if (off_axis > kOffAxisWarn * profile.max_radius_mm())
    report.warn("tool.mesh: " + found + "; rotation about z is assumed");
  const Aabb box = mesh.bounds();
  if (box.min.z() < -kBelowOriginWarn_mm || box.min.z() > kOffOriginWarn * (box.max.z() - box.min.z()))
    report.warn(
        fmt::format("tool.mesh: the tool's lowest point is at z = {:.4g} mm; it should be at z = 0, because poses "
                    "refer to that point",
                    box.min.z()));
}

int least_resolution(const ToolSettings& settings, double extent_mm, double voxel_mm, ShellUse use) {
  const auto cells_at = [&](double spacing) {
    return std::ceil(extent_mm / (spacing * voxel_mm) * (1 - kSpacingSlack)) + 1;
  };
  const int most = use == ShellUse::none ? kGridResolution : kMaxShellResolution;
  const double cells = cells_at(kSafeSpacingVoxels);
  if (cells <= kMaxShellResolution || use == ShellUse::none) {
    return static_cast<int>(std::clamp<double>(cells_at(kChosenSpacingVoxels), 2, most));
  }
  const double least_voxel = extent_mm / (kMaxShellResolution - 1) / kSafeSpacingVoxels;
  throw InputError(fmt::format(
      "tool.shell_resolution: a spacing of half a voxel ({:.4g} mm) over the tool {} ({:.4g} mm) takes {:.4g} cells "
      "per axis and {} are possible; bone.voxel_mm of {:.4g} or more is enough, or tool.shell_resolution: {} with a "
      "leak, "
      "which is warned of",
      kSafeSpacingVoxels * voxel_mm, settings.mesh, extent_mm, cells, kMaxShellResolution,
      std::ceil(least_voxel * 1e4) / 1e4, kMaxShellResolution));
}

void warn_of_leak(const PointShell& shell, double voxel_mm, Diagnostics& report) {
  const double spacing = shell.cell_mm / voxel_mm;
  if (spacing <= kSafeSpacingVoxels * (1 + 2 * kSpacingSlack)) return;
  const std::string bound = spacing <= kHardlyLeakingSpacing    ? "less than "
                            : spacing > kLargestMeasuredSpacing ? "more than "
                                                                : "about ";
  report.warn(
      fmt::format("tool.shell_resolution: the shell's spacing is {:.4g} voxels; {}{:.4g} % of the swept voxels may "
                  "survive; use 0.5 voxels or less",
                  spacing, bound, 100 * expected_leak(spacing)));
}

/// Offset of a ray's origin below the surface, as a fraction of its length, so that it does not hit its own face.
constexpr double kSkin = 1e-3;
/// Largest angle between the faces of a wall, 30° in rad. Sharp edges do not count: at their tip the error of one plane
/// per voxel is of the order of the square of the voxel.
constexpr double kWallAngle = 0.5235987756;
/// Thinner walls cause a warning, voxels: one plane per voxel cannot represent both faces.
constexpr double kThinWallVoxels = 2;

using Triangle = std::array<Vec3, 3>;

/// Triangles by the cells of a cubic lattice that they intersect.
class TriangleCells {
 public:
  TriangleCells(const std::vector<Triangle>& triangles, double cell_mm) : triangles_(triangles), cell_mm_(cell_mm) {
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const Vec3 &a = triangles[t][0], &b = triangles[t][1], &c = triangles[t][2];
      each_cell(a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c), [&](const Vec3i& cell) {
        const Vec3 center = cell_mm_ * (cell.cast<double>().array() + 0.5).matrix();
        if (!triangle_touches_box(a, b, c, center, Vec3::Constant(0.5 * cell_mm_ * (1 + kSkin)))) return;
        cells_[{cell.x(), cell.y(), cell.z()}].push_back(t);
      });
    }
  }

  /// The nearest triangle on a ray along the unit vector `along`, and its distance; `length_mm` without a hit.
  struct Hit {
    double distance_mm;
    std::size_t triangle = 0;
  };
  [[nodiscard]] Hit first_hit(const Vec3& from, const Vec3& along, double length_mm) const {
    Hit hit{length_mm};
    const Vec3 end = from + length_mm * along;
    each_cell(from.cwiseMin(end), from.cwiseMax(end), [&](const Vec3i& cell) {
      const auto found = cells_.find({cell.x(), cell.y(), cell.z()});
      if (found == cells_.end()) return;
      for (const std::size_t t : found->second) {
        const double distance = ray_distance(triangles_[t], from, along);
        if (distance < hit.distance_mm) hit = {distance, t};
      }
    });
    return hit;
  }

 private:
  template <typename Body>
  void each_cell(const Vec3& low, const Vec3& high, const Body& body) const {
    const Vec3i first = (low / cell_mm_).array().floor().cast<int>(),
                last = (high / cell_mm_).array().floor().cast<int>();
    for_each_voxel(first, last, body);
  }

  /// Distance along the ray to the triangle (Möller and Trumbore 1997); infinite without a hit.
  static double ray_distance(const Triangle& t, const Vec3& from, const Vec3& along) {
    constexpr double kNone = std::numeric_limits<double>::infinity();
    const Vec3 ab = t[1] - t[0], ac = t[2] - t[0], p = along.cross(ac);
    const double determinant = ab.dot(p);
    if (determinant == 0) return kNone;
    const Vec3 s = from - t[0], q = s.cross(ab);
    const double u = s.dot(p) / determinant, v = along.dot(q) / determinant, distance = ac.dot(q) / determinant;
    return u >= 0 && v >= 0 && u + v <= 1 && distance > 0 ? distance : kNone;
  }

  const std::vector<Triangle>& triangles_;
  double cell_mm_;
  using Cell = std::array<int, 3>;
  std::unordered_map<Cell, std::vector<std::size_t>, boost::hash<Cell>> cells_;
};

Vec3 normal_of(const Triangle& t) {
  return (t[1] - t[0]).cross(t[2] - t[0]).normalized();
}

/// Calls body(point) for points of a triangle, at most `step_mm` apart.
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

/// The profile's edges off the axis, and their mirror images.
std::vector<Side> sides_of(const Profile& profile) {
  std::vector<Side> sides;
  for_each_side(profile.points, [&sides](const Vec2& a, const Vec2& b) {
    if (a == b || (Profile::on_axis(a) && Profile::on_axis(b))) return;
    const Vec2 along = (b - a).normalized();
    sides.push_back({a, b, {along.y(), -along.x()}});
  });
  const std::size_t half = sides.size();
  for (std::size_t i = 0; i < half; ++i) {
    const auto mirrored = [](const Vec2& v) { return Vec2(-v.x(), v.y()); };
    sides.push_back({mirrored(sides[i].begin), mirrored(sides[i].end), mirrored(sides[i].normal)});
  }
  return sides;
}

/// The nearest side on the ray within `length_mm`, or nullptr, and its distance.
const Side* first_side(const std::vector<Side>& sides, const Vec2& from, const Vec2& along, double length_mm,
                       double& distance_mm) {
  const Side* first = nullptr;
  distance_mm = length_mm;
  for (const Side& side : sides) {
    const Vec2 edge = side.end - side.begin, to = side.begin - from;
    const double cross = along.x() * edge.y() - along.y() * edge.x();
    if (cross == 0) continue;
    const double distance = (to.x() * edge.y() - to.y() * edge.x()) / cross;
    const double t = (to.x() * along.y() - to.y() * along.x()) / cross;
    if (distance <= 0 || distance >= distance_mm || t < 0 || t > 1) continue;
    distance_mm = distance;
    first = &side;
  }
  return first;
}

void warn_of_thin_walls(const Tool& tool, bool teeth, double voxel_mm, Diagnostics& report) {
  const double limit_mm = kThinWallVoxels * voxel_mm;
  const auto wall = teeth ? thinnest_wall(tool.mesh, limit_mm) : thinnest_wall(tool.profile, limit_mm);
  if (!wall) return;
  report.warn(fmt::format(
      "tool.mesh: a wall of the tool is {:.3g} mm thick at ({:.3g}, {:.3g}, {:.3g}) mm, less than two voxels ({:.3g} "
      "mm); its cut is inaccurate: use voxels of {:.3g} mm or less",
      wall->thickness_mm, wall->at_mm.x(), wall->at_mm.y(), wall->at_mm.z(), limit_mm,
      wall->thickness_mm / kThinWallVoxels));
}

void report_volume(const DistanceGrid& grid, Diagnostics& report) {
  const std::string text = fmt::format(
      "tool: the distance grid has {} bricks, sample spacing {:.3g} mm, volume {:.2f} mm3; the mesh has {:.2f} "
      "mm3 ({:+.3f} %)",
      grid.stored_bricks(), grid.spacing_mm, grid.volume_mm3, grid.mesh_mm3, 100 * grid.volume_error());
  if (std::abs(grid.volume_error()) <= kGridVolumeTolerance) return report.note(text);
  report.warn(text + fmt::format("; the difference exceeds {:.1f} %: use smaller voxels", 100 * kGridVolumeTolerance));
}

}  // namespace

Tool load_tool(const ToolSettings& settings, double voxel_mm, ShellUse use, Diagnostics& report) {
  Tool tool;
  tool.mesh = read_closed_part({settings.mesh, settings.scale, "tool.mesh", "tool.scale", "tool", voxel_mm}, report);
  try {
    Envelope envelope = envelope_of_revolution(tool.mesh);
    tool.profile = std::move(envelope.profile);
    tool.revolved = envelope.revolved;
  } catch (const InputError& error) {
    throw tool_error(settings, error.what(), "");
  }
  check_frame(settings, tool.mesh, tool.profile, report);

  tool.spin = settings.spin;
  tool.holder = settings.holder;
  const bool teeth = settings.spin == ToolSpin::resolved;
  tool.bounds = teeth ? tool.mesh.bounds() : tool.profile.bounds();
  const double extent = (tool.bounds.max - tool.bounds.min).maxCoeff();
  const int resolution =
      settings.shell_resolution > 0 ? settings.shell_resolution : least_resolution(settings, extent, voxel_mm, use);
  if (use == ShellUse::none) {
    tool.shell = shell_grid(tool.bounds, resolution);
    for (const Vec3& vertex : tool.mesh.vertices) tool.reach_mm = std::max(tool.reach_mm, vertex.norm());
    return tool;
  }
  const double cell = extent / std::max(1, resolution - 1);
  tool.shell = voxelize_surface(
      teeth ? tool.mesh : revolve(tool.profile, segments_for_sagitta(tool.profile.max_radius_mm(), kFacetCells * cell)),
      resolution);
  warn_of_leak(tool.shell, voxel_mm, report);
  for (const std::uint64_t code : tool.shell.codes) {
    const Vec3 point =
        tool.shell.origin_mm + tool.shell.cell_mm * (morton_decode(code).cast<double>().array() + 0.5).matrix();
    tool.reach_mm = std::max(tool.reach_mm, point.norm());
  }
  return tool;
}

std::optional<ThinWall> thinnest_wall(const TriangleMesh& mesh, double limit_mm) {
  std::vector<Triangle> triangles;
  for (const auto& triangle : mesh.triangles) {
    const Triangle t = mesh.corners(triangle);
    if (normal_of(t).norm() > 0.5) triangles.push_back(t);  // no area, no normal
  }
  const TriangleCells cells(triangles, limit_mm);
  const double skin = kSkin * limit_mm;
  std::optional<ThinWall> thinnest;
  for (const Triangle& t : triangles) {
    const Vec3 normal = normal_of(t);
    each_point(t, 0.5 * limit_mm, [&](const Vec3& at) {
      const auto hit = cells.first_hit(at - skin * normal, -normal, limit_mm - skin);
      if (hit.distance_mm >= limit_mm - skin) return;
      if (normal_of(triangles[hit.triangle]).dot(normal) > -std::cos(kWallAngle)) return;
      keep_thinner(hit.distance_mm + skin, at, thinnest);
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
      double distance = 0;
      const Side* other = first_side(sides, at - skin * side.normal, -side.normal, limit_mm - skin, distance);
      if (other == nullptr || other->normal.dot(side.normal) > -std::cos(kWallAngle)) continue;
      keep_thinner(distance + skin, {at.x(), 0, at.y()}, thinnest);
    }
  }
  return thinnest;
}

void prepare_clipping(Tool& tool, const ToolSettings& settings, double voxel_mm, double memory_bytes,
                      Diagnostics& report) {
  const bool teeth = settings.spin == ToolSpin::resolved && !tool.revolved;
  warn_of_thin_walls(tool, teeth, voxel_mm, report);
  if (!teeth) {
    if (settings.spin == ToolSpin::resolved)
      report.note("tool.spin is resolved but the mesh is a surface of revolution; using its envelope");
    return;
  }
  require_room_for_grid(plan_distance_grid(tool.mesh, voxel_mm).working_bytes, memory_bytes, voxel_mm, "the machine");
  tool.teeth = make_distance_grid(tool.mesh, tool.profile, voxel_mm);
  report_volume(*tool.teeth, report);
}

}  // namespace reamsim
