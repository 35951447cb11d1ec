// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/implant_mesh.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/anatomy/run_metrics.h"
#include "sim/base/parallel.h"
#include "sim/mesh/mesh_check.h"
#include "sim/mesh/mesh_io.h"

namespace reamsim {

namespace {

constexpr int kDirections = 72;  // around the axis of a capsule
constexpr int kLatitudes = 18;   // of the hemisphere at its end
constexpr double kCell_mm = 0.1;

using Corners = std::array<Vec3, 3>;

/// Unit vector out of the mesh; 0 for a triangle without area.
Vec3 normal_of(const Corners& t) {
  const Vec3 across = (t[1] - t[0]).cross(t[2] - t[0]);
  return across.norm() > 0 ? Vec3(across.normalized()) : Vec3(0, 0, 0);
}

/// Points on the line in which a triangle meets the plane at a height.
void add_section(const Corners& t, double z_mm, double spacing_mm, std::vector<PegPoint>& out) {
  std::vector<Vec3> ends;
  for (std::size_t c = 0; c < 3; ++c) {
    const Vec3 &a = t[c], &b = t[(c + 1) % 3];
    if ((a.z() > z_mm) == (b.z() > z_mm)) continue;
    ends.emplace_back(a + (z_mm - a.z()) / (b.z() - a.z()) * (b - a));
  }
  if (ends.size() != 2) return;
  const double count = std::ceil((ends[1] - ends[0]).norm() / spacing_mm);
  for (double i = 0.5; i < count; ++i) out.push_back({ends[0] + i / count * (ends[1] - ends[0]), normal_of(t)});
}

/// Points of a triangle: the centres of equal parts of it.
void add_points(const Corners& t, double spacing_mm, std::vector<PegPoint>& out) {
  const double longest = std::max({(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()});
  const int parts = std::max(static_cast<int>(std::ceil(longest / spacing_mm)), 1);
  for (int i = 0; i < parts; ++i) {
    for (int j = 0; i + j < parts; ++j) {
      const double u = (i + 1.0 / 3) / parts, v = (j + 1.0 / 3) / parts;
      out.push_back({t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]), normal_of(t)});
    }
  }
}

PegSurface surface_of(const std::vector<Corners>& triangles, double step_mm, double spacing_mm) {
  Aabb box = Aabb::none();
  PegSurface out;
  PegSurface::Part& whole = out.ends.emplace_back();
  for (const Corners& t : triangles) {
    for (const Vec3& corner : t) box.extend(corner);
    add_points(t, spacing_mm, whole.points);
  }
  whole.center_mm = Vec3(box.center().x(), box.center().y(), box.min.z());
  const double count = std::ceil((box.max.z() - box.min.z()) / step_mm);
  const double length_mm = (box.max.z() - box.min.z()) / count;
  for (double i = 0.5; i < count; ++i) {
    PegSurface::Part section{.center_mm = Vec3::Zero(), .length_mm = length_mm, .points = {}};
    for (const Corners& t : triangles) add_section(t, box.max.z() - i * length_mm, spacing_mm, section.points);
    if (section.points.empty()) continue;
    for (const PegPoint& p : section.points) section.center_mm += p.at_mm / static_cast<double>(section.points.size());
    out.circumferences.push_back(std::move(section));
  }
  if (!out.circumferences.empty()) {
    out.axis_mm = {out.circumferences.front().center_mm, out.circumferences.back().center_mm};
  }
  return out;
}

}  // namespace

PegSurface capsule_surface(const PegSettings& peg, double step_mm) {
  const double length_mm = (peg.to_mm - peg.from_mm).norm(), radius_mm = peg.diameter_mm / 2;
  const Vec3 along = (peg.to_mm - peg.from_mm) / length_mm;
  const Vec3 across = along.unitOrthogonal(), third = along.cross(across);
  /// Adds the points of a parallel of a hemisphere, `latitude` rad from the circumference.
  const auto add_ring = [&](PegSurface::Part& part, double latitude, double way, int points) {
    for (int n = 0; n < points; ++n) {
      const double angle = 2 * std::numbers::pi * n / kDirections;
      const Vec3 around = std::cos(angle) * across + std::sin(angle) * third;
      const Vec3 outward = std::cos(latitude) * around + way * std::sin(latitude) * along;
      part.points.push_back({part.center_mm + radius_mm * outward, outward});
    }
  };
  PegSurface out;
  out.axis_mm = {peg.from_mm, peg.to_mm};
  const double count = std::ceil(length_mm / step_mm);
  for (double i = 0.5; i < count; ++i) {
    const Vec3 center = peg.from_mm + i / count * length_mm * along;
    add_ring(out.circumferences.emplace_back(PegSurface::Part{center, length_mm / count, {}}), 0, 1, kDirections);
  }
  for (const auto& [center, way] : {std::pair{peg.from_mm, -1.0}, std::pair{peg.to_mm, 1.0}}) {
    PegSurface::Part& end = out.ends.emplace_back(PegSurface::Part{center, 0, {}});
    for (int i = 1; i <= kLatitudes; ++i) {
      add_ring(end, 0.5 * std::numbers::pi * i / kLatitudes, way, i == kLatitudes ? 1 : kDirections);
    }
  }
  return out;
}

TriangleMesh read_implant_mesh(const ImplantSettings& settings, Diagnostics& report) {
  constexpr double kLeastBack = 0.5;
  const ImplantMeshSettings& given = *settings.mesh;
  const PartFile file{given.path, given.scale, "metrics.implant.mesh.path", "metrics.implant.mesh.scale", "implant"};
  TriangleMesh mesh = read_closed_part(file, report);
  const double back = ImplantShape(settings, &mesh).back_fraction();
  if (back < kLeastBack) {
    throw file.error(fmt::format("{:.0f} % of its underside lie within {:.4g} mm (pegs_below_mm) of the plain back",
                                 100 * back, given.pegs_below_mm),
                     "expected half of it or more: the apex of the back at the origin, +z out of the bone, in mm by "
                     "scale, and backside_radius_mm");
  }
  return mesh;
}

ImplantUnderside::ImplantUnderside(const TriangleMesh& mesh) : lines_(mesh, 2) {
  const Aabb box = mesh.bounds();
  reach_mm_ = std::max(box.max.head<2>().cwiseAbs().maxCoeff(), box.min.head<2>().cwiseAbs().maxCoeff());
  cells_ = 2 * static_cast<int>(std::ceil(reach_mm_ / kCell_mm));
  covered_.resize(static_cast<std::size_t>(cells_) * static_cast<std::size_t>(cells_));
  parallel_items(static_cast<std::size_t>(cells_), [&](std::size_t row) {
    for (int i = 0; i < cells_; ++i) {
      const Vec2 cell = Vec2(i, static_cast<double>(row)) + Vec2::Constant(0.5 - cells_ / 2);
      covered_[row * static_cast<std::size_t>(cells_) + static_cast<std::size_t>(i)] = at(kCell_mm * cell) ? 1 : 0;
    }
  });
}

std::optional<double> ImplantUnderside::at(const Vec2& place) const {
  std::vector<LineCrossings::Crossing> crossings;
  lines_.along(place.x(), place.y(), crossings);
  return crossings.empty() ? std::nullopt : std::optional(crossings.front().at_mm);
}

bool ImplantUnderside::covers(const Vec2& place) const {
  const Vec2 cell = (place / kCell_mm).array().floor() + cells_ / 2;
  if (cell.minCoeff() < 0 || cell.maxCoeff() >= cells_) return false;
  return covered_[static_cast<std::size_t>(cell.y()) * static_cast<std::size_t>(cells_) +
                  static_cast<std::size_t>(cell.x())] != 0;
}

std::vector<PegSurface> peg_surfaces(const TriangleMesh& mesh, const std::function<bool(const Vec3&)>& is_peg,
                                     double step_mm, double spacing_mm) {
  TriangleMesh pegs{.vertices = mesh.vertices, .triangles = {}};
  std::vector<char> deep;
  for (const Vec3& vertex : mesh.vertices) deep.push_back(is_peg(vertex) ? 1 : 0);
  for (const MeshTriangle& t : mesh.triangles) {
    const auto in_peg = [&](std::int32_t vertex) { return deep[static_cast<std::size_t>(vertex)] != 0; };
    if (std::ranges::any_of(t, in_peg)) pegs.triangles.push_back(t);
  }
  const std::vector<std::size_t> parts = components_of(pegs);
  std::vector<std::vector<Corners>> triangles;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    triangles.resize(std::max(triangles.size(), parts[i] + 1));
    triangles[parts[i]].push_back(pegs.corners(pegs.triangles[i]));
  }
  std::vector<PegSurface> out;
  for (const auto& part : triangles) out.push_back(surface_of(part, step_mm, spacing_mm));
  return out;
}

}  // namespace reamsim
