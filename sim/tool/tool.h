// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>

#include "sim/base/error.h"
#include "sim/mesh/triangle_mesh.h"
#include "sim/scenario/scenario.h"
#include "sim/tool/distance_grid.h"
#include "sim/tool/point_shell.h"
#include "sim/tool/profile.h"

namespace reamsim {

/// The reamer in the tool frame T: origin at the lowest point of the cutting surface on the axis, +z towards the drive.
struct Tool {
  TriangleMesh mesh;    ///< with cutting edges; for pictures
  Profile profile;      ///< envelope of revolution about z
  PointShell shell;     ///< of the envelope (`spin: envelope`) or of the mesh (`spin: resolved`); without
                        ///< points in a run that uses none
  Aabb bounds;          ///< of the shell's surface, T, mm
  double reach_mm = 0;  ///< farthest point of the shell, or of the surface without one, from T's origin
  ToolSpin spin = ToolSpin::envelope;
  bool revolved = false;                     ///< the mesh is the surface of revolution of the profile
  std::vector<HolderPartSettings> holder{};  ///< shaft and holder, which do not cut
  std::optional<DistanceGrid> teeth;  ///< distance to resolved cutting edges, for `erosion: exact` (prepare_clipping())

  /// Bound of the distance of the clipping surface outside the profile.
  [[nodiscard]] double clip_slack_mm() const { return teeth ? teeth->slack_mm : 0; }
  /// Bounds of the clipping surface, T, mm.
  [[nodiscard]] Aabb clip_bounds() const { return profile.bounds().expanded(clip_slack_mm()); }
};

enum class ShellUse {
  touches_voxels,  ///< its points determine the touched voxels; a coarse shell misses some
  none,            ///< voxels are tested against the surface; the shell has a grid but no points
};

/// Reads the mesh, computes its envelope of revolution and samples its surface. Without a resolution in the scenario
/// the shell's spacing is at most half of `voxel_mm`; a given one that leaks (expected_leak()) causes a warning. Throws
/// InputError: unreadable or open mesh, no axis of revolution, a shell of more than 4096³ cells that touches voxels.
Tool load_tool(const ToolSettings& settings, double voxel_mm, ShellUse use, Diagnostics& report);

/// The thinnest wall of a solid.
struct ThinWall {
  double thickness_mm = 0;
  Vec3 at_mm = Vec3::Zero();  ///< on the surface
};

/// The thinnest wall of a closed mesh that faces outwards, if it is thinner than `limit_mm`: the shortest distance
/// along inward normals, from surface points half the limit apart, to an opposite face.
std::optional<ThinWall> thinnest_wall(const TriangleMesh& mesh, double limit_mm);

/// The same for the solid of revolution of a profile; `at_mm` has y = 0.
std::optional<ThinWall> thinnest_wall(const Profile& profile, double limit_mm);

/// Tolerated error of the grid's volume relative to the mesh's; larger ones cause a warning.
inline constexpr double kGridVolumeTolerance = 5e-3;

/// Prepares a tool for `erosion: exact`: warns of thin walls, and makes the distance grid of resolved cutting edges
/// unless the mesh is a surface of revolution. Throws InputError where it would need more than `memory_bytes`.
void prepare_clipping(Tool& tool, const ToolSettings& settings, double voxel_mm, double memory_bytes,
                      Diagnostics& report);

}  // namespace reamsim
