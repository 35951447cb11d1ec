// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/tool.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "sim/mesh/mesh_check.h"
#include "sim/mesh/mesh_io.h"

namespace reamsim {

namespace {

/// Largest shell spacing without missed voxels, in voxels (docs/erosion.md, 2).
constexpr double kSafeSpacingVoxels = 0.5;
/// Automatic spacing, in voxels: below the safe one, and no simple fraction of a voxel. At exactly half a voxel,
/// aligned with the lattice, all layers of points would enter their next layers of voxels in the same frame.
constexpr double kChosenSpacingVoxels = 0.4721;
/// Limit of the automatic resolution of a shell without points.
constexpr int kGridResolution = 1024;
/// Relative tolerance of the spacing, for the rounding of coordinates in an STL.
constexpr double kSpacingSlack = 1e-6;
constexpr double kLargestMm = 1000;
/// Tolerated sagitta of the revolved envelope's facets, cells.
constexpr double kFacetCells = 0.02;
/// Distance of the centroid from the axis, relative to the largest radius: above the first a warning, above the second
/// an error, because the mesh is not in the tool frame.
constexpr double kOffAxisWarn = 0.01;
constexpr double kOffAxisError = 0.1;
/// Distance of the lowest point from z = 0 that is warned of, relative to the tool's height: a cannula can lift it.
constexpr double kOffOriginWarn = 0.1;
/// No cannula puts it below z = 0 by more than the rounding of a mesh.
constexpr double kBelowOriginWarn_mm = 0.01;

std::string text(double value) {
  return fmt::format("{:.4g}", value);
}

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

TriangleMesh read_closed_mesh(const ToolSettings& settings, double voxel_mm, Diagnostics& report) {
  MeshContents contents = read_mesh_contents(settings.mesh, settings.scale, "tool.mesh");
  for (const std::string& warning : contents.warnings) report.warn("tool.mesh: " + warning);
  for (const std::string& note : contents.notes) report.note("tool.mesh: " + note);
  if (!contents.space.empty()) {
    report.note("tool.mesh: the header says SPACE=" + contents.space +
                "; the coordinates of a tool are taken as they stand, in the tool frame");
  }
  TriangleMesh mesh = std::move(contents.mesh);
  const MeshDiagnosis diagnosis = diagnose(mesh);
  if (!diagnosis.closed_manifold()) throw tool_error(settings, diagnosis.text(), "give a closed two-manifold surface");
  const Vec3 size = mesh.bounds().max - mesh.bounds().min;
  if (!(size.minCoeff() > voxel_mm) || !(size.maxCoeff() < kLargestMm) || !(std::abs(diagnosis.volume_mm3) > 0))
    throw tool_error(settings,
                     "the tool measures " + text(size.x()) + " × " + text(size.y()) + " × " + text(size.z()) + " mm",
                     "more than a voxel (" + text(voxel_mm) + " mm) and less than 1 m are supported: check tool.scale");
  if (diagnosis.volume_mm3 < 0) {
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
    report.warn("tool.mesh: the triangles of " + settings.mesh + " face inwards; orientation flipped");
  }
  return mesh;
}

/// The mesh must be in the tool frame: spin axis on z, cutting end at the origin.
void check_frame(const ToolSettings& settings, const TriangleMesh& mesh, const Profile& profile, Diagnostics& report) {
  const double off_axis = centroid(mesh).head<2>().norm();
  const std::string found = "the mesh's centroid is " + text(off_axis) + " mm off the z axis";
  if (off_axis > kOffAxisError * profile.max_radius_mm())
    throw tool_error(settings, found, "place the spin axis on z, with +z towards the drive");
  if (off_axis > kOffAxisWarn * profile.max_radius_mm())
    report.warn("tool.mesh: " + found + "; rotation about z is assumed");
  const Aabb box = mesh.bounds();
  if (box.min.z() < -kBelowOriginWarn_mm || box.min.z() > kOffOriginWarn * (box.max.z() - box.min.z()))
    report.warn("tool.mesh: the tool's lowest point is at z = " + text(box.min.z()) +
                " mm; it should be at z = 0, because poses refer to that point");
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
  throw InputError("tool.shell_resolution: a spacing of half a voxel (" + text(kSafeSpacingVoxels * voxel_mm) +
                   " mm) over the tool " + settings.mesh + " (" + text(extent_mm) + " mm) takes " + text(cells) +
                   " cells per axis and " + std::to_string(kMaxShellResolution) + " are possible; bone.voxel_mm of " +
                   text(std::ceil(least_voxel * 1e4) / 1e4) + " or more is enough, or tool.shell_resolution: " +
                   std::to_string(kMaxShellResolution) + " with a leak, which is warned of");
}

void warn_of_leak(const PointShell& shell, double voxel_mm, Diagnostics& report) {
  const double spacing = shell.cell_mm / voxel_mm;
  if (spacing <= kSafeSpacingVoxels * (1 + 2 * kSpacingSlack)) return;
  const std::string bound = spacing <= kHardlyLeakingSpacing    ? "less than "
                            : spacing > kLargestMeasuredSpacing ? "more than "
                                                                : "about ";
  report.warn("tool.shell_resolution: the shell's spacing is " + text(spacing) + " voxels; " + bound +
              text(100 * expected_leak(spacing)) + " % of the swept voxels may survive; use 0.5 voxels or less");
}

}  // namespace

Tool load_tool(const ToolSettings& settings, double voxel_mm, ShellUse use, Diagnostics& report) {
  Tool tool;
  tool.mesh = read_closed_mesh(settings, voxel_mm, report);
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
  const double radius = tool.profile.max_radius_mm();
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
      teeth ? tool.mesh : revolve(tool.profile, segments_for_sagitta(radius, kFacetCells * cell)), resolution);
  warn_of_leak(tool.shell, voxel_mm, report);
  for (const std::uint64_t code : tool.shell.codes) {
    const Vec3 point =
        tool.shell.origin_mm + tool.shell.cell_mm * (morton_decode(code).cast<double>().array() + 0.5).matrix();
    tool.reach_mm = std::max(tool.reach_mm, point.norm());
  }
  return tool;
}

}  // namespace reamsim
