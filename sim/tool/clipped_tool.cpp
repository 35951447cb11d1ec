// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/clipped_tool.h"

#include <fmt/core.h>
#include <cmath>
#include <string>

#include "sim/tool/thin_walls.h"

namespace reamsim {

namespace {

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

bool has_resolved_teeth(const Tool& tool, const ToolSettings& settings) {
  return settings.spin == ToolSpin::resolved && !tool.revolved;
}

void prepare_clipping(Tool& tool, const ToolSettings& settings, double voxel_mm, double memory_bytes,
                      Diagnostics& report) {
  const bool teeth = has_resolved_teeth(tool, settings);
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
