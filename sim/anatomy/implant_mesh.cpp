// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/run_metrics.h"

#include <fmt/core.h>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>

#include "sim/mesh/mesh_check.h"
#include "sim/mesh/mesh_io.h"

namespace reamsim {

namespace {

constexpr double kStationVoxels = 0.1;    // between circumferences
constexpr double kPointVoxels = 0.2;      // between points of a mesh, at least:
constexpr double kPointsOfPeg = 20000;    // of equal spacing on the surface of a peg
constexpr int kDirections = 72;           // around the axis of a capsule
constexpr int kLatitudes = 18;            // of the hemisphere at its end
constexpr int kCircumferencesPerFan = 5;  // rays start at every fifth circumference

using Corners = std::array<Vec3, 3>;

/// Points of a triangle: the centroids of parts with edges of at most `spacing_mm`.
void add_points(const Corners& t, double spacing_mm, std::vector<PegPoint>& out) {
  std::size_t c = 0;  // where the longest edge begins
  for (std::size_t i = 1; i < 3; ++i) {
    if ((t[(i + 1) % 3] - t[i]).norm() > (t[(c + 1) % 3] - t[c]).norm()) c = i;
  }
  const Vec3 &from = t[c], &to = t[(c + 1) % 3], &opposite = t[(c + 2) % 3];
  if ((to - from).norm() > spacing_mm) {
    add_points({from, (from + to) / 2, opposite}, spacing_mm, out);
    add_points({(from + to) / 2, to, opposite}, spacing_mm, out);
  } else if (const Vec3 across = (to - from).cross(opposite - from); across.norm() > 0) {
    out.push_back({(from + to + opposite) / 3, across.normalized()});
  }
}

/// Points at most `step_mm` apart, or farther on a large surface, in layers across z as thick.
PegSurface surface_of(const std::vector<Corners>& triangles, double step_mm) {
  Aabb box = Aabb::none();
  double area_mm2 = 0;
  for (const Corners& t : triangles) {
    for (const Vec3& corner : t) box.extend(corner);
    area_mm2 += (t[1] - t[0]).cross(t[2] - t[0]).norm() / 2;
  }
  step_mm = std::max(step_mm, std::sqrt(area_mm2 / kPointsOfPeg));
  PegSurface out;
  for (const Corners& t : triangles) add_points(t, step_mm, out.rays);
  if (out.rays.empty()) return out;
  const double count = std::max(std::ceil((box.max.z() - box.min.z()) / step_mm), 1.0);
  const double length_mm = (box.max.z() - box.min.z()) / count;
  out.circumferences.resize(static_cast<std::size_t>(count));
  for (const PegPoint& p : out.rays) {
    const double layer = std::clamp(std::floor((box.max.z() - p.at_mm.z()) / length_mm), 0.0, count - 1);
    out.circumferences[static_cast<std::size_t>(layer)].points.push_back(p);
  }
  std::erase_if(out.circumferences, [](const PegSurface::Circumference& one) { return one.points.empty(); });
  for (PegSurface::Circumference& one : out.circumferences) {
    one.length_mm = length_mm;
    for (const PegPoint& p : one.points) one.center_mm += p.at_mm / static_cast<double>(one.points.size());
  }
  out.axis_mm = {out.circumferences.front().center_mm, out.circumferences.back().center_mm};
  return out;
}

/// A peg whose points are all within diameter/2 of a segment. `step_mm`: largest distance between circumferences.
PegSurface capsule_surface(const PegSettings& peg, double step_mm) {
  const double length_mm = (peg.to_mm - peg.from_mm).norm(), radius_mm = peg.diameter_mm / 2;
  const Vec3 along = (peg.to_mm - peg.from_mm) / length_mm;
  const Vec3 across = along.unitOrthogonal(), third = along.cross(across);
  // The parallel of a hemisphere about `center`, `latitude` rad from its circumference.
  const auto add_ring = [&](const Vec3& center, double latitude, double way, std::vector<PegPoint>& out) {
    for (int n = 0; n < kDirections; ++n) {
      const double angle = 2 * std::numbers::pi * n / kDirections;
      const Vec3 around = std::cos(angle) * across + std::sin(angle) * third;
      const Vec3 outward = std::cos(latitude) * around + way * std::sin(latitude) * along;
      out.push_back({center + radius_mm * outward, outward});
    }
  };
  PegSurface out;
  out.axis_mm = {peg.from_mm, peg.to_mm};
  const int count = static_cast<int>(std::ceil(length_mm / step_mm));
  for (int i = 0; i < count; ++i) {
    const Vec3 center = peg.from_mm + (i + 0.5) / count * length_mm * along;
    PegSurface::Circumference& one = out.circumferences.emplace_back();
    one.center_mm = center;
    one.length_mm = length_mm / count;
    add_ring(center, 0, 1, one.points);
    if (i % kCircumferencesPerFan == 0) add_ring(center, 0, 1, out.rays);
  }
  for (int i = 1; i <= kLatitudes; ++i) {
    const double latitude = 0.5 * std::numbers::pi * i / kLatitudes;
    add_ring(peg.from_mm, latitude, -1, out.rays);
    add_ring(peg.to_mm, latitude, 1, out.rays);
  }
  return out;
}

std::vector<PegSurface> pegs_of_mesh(const TriangleMesh& mesh, const ImplantShape& shape, double step_mm) {
  const auto in_peg = [&](std::int32_t vertex) {
    return shape.is_peg(mesh.vertices[static_cast<std::size_t>(vertex)]);
  };
  TriangleMesh pegs{.vertices = mesh.vertices, .triangles = {}};
  std::ranges::copy_if(mesh.triangles, std::back_inserter(pegs.triangles),
                       [&](const MeshTriangle& t) { return std::ranges::any_of(t, in_peg); });
  const std::vector<std::size_t> parts = components_of(pegs);
  std::vector<std::vector<Corners>> triangles;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    triangles.resize(std::max(triangles.size(), parts[i] + 1));
    triangles[parts[i]].push_back(pegs.corners(pegs.triangles[i]));
  }
  std::vector<PegSurface> out;
  for (const auto& part : triangles) {
    PegSurface peg = surface_of(part, step_mm);
    if (!peg.rays.empty()) out.push_back(std::move(peg));  // an empty one has no area
  }
  return out;
}

}  // namespace

TriangleMesh read_implant_mesh(const ImplantSettings& settings, Diagnostics& report) {
  constexpr double kLeastBack = 0.5, kLargest_mm = 200;
  const ImplantMeshSettings& given = *settings.mesh;
  const PartFile file{given.path, given.scale, "metrics.implant.mesh.path", "metrics.implant.mesh.scale", "implant"};
  TriangleMesh mesh = read_closed_part(file, report);
  const Aabb box = mesh.bounds();
  if (box.min.head<2>().maxCoeff() >= 0 || box.max.head<2>().minCoeff() <= 0 ||
      (box.max - box.min).maxCoeff() > kLargest_mm) {
    throw file.error(fmt::format("it reaches from ({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, {:.4g}, {:.4g}) mm", box.min.x(),
                                 box.min.y(), box.min.z(), box.max.x(), box.max.y(), box.max.z()),
                     "expected at most 200 mm, with the axis of the implant, x = y = 0, inside");
  }
  const double back = ImplantShape(settings, &mesh).back_fraction();
  if (back < kLeastBack) {
    throw file.error(fmt::format("{:.0f} % of its underside lie within {:.4g} mm (pegs_below_mm) of the plain back",
                                 100 * back, given.pegs_below_mm),
                     "expected half of it or more: the apex of the back at the origin, +z out of the bone, in mm by "
                     "scale, and backside_radius_mm");
  }
  return mesh;
}

std::vector<PegSurface> surfaces_of_pegs(const ImplantSettings& settings, const ImplantShape& shape,
                                         const TriangleMesh* mesh, double voxel_mm) {
  if (mesh != nullptr && settings.mesh) return pegs_of_mesh(*mesh, shape, kPointVoxels * voxel_mm);
  std::vector<PegSurface> out;
  for (const PegSettings& peg : settings.pegs) out.push_back(capsule_surface(peg, kStationVoxels * voxel_mm));
  return out;
}

}  // namespace reamsim
