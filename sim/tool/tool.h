#pragma once

#include <optional>

#include "sim/base/report.h"
#include "sim/mesh/triangle_mesh.h"
#include "sim/scenario/scenario.h"
#include "sim/tool/distance_grid.h"
#include "sim/tool/point_shell.h"
#include "sim/tool/profile.h"

namespace reamsim {

/// The reamer, in the tool frame T: origin at the lowest point of the cutting surface on the spin axis, +z out of the
/// bone towards the drill.
struct Tool {
  TriangleMesh mesh;                  ///< as it looks, teeth included; for pictures
  Profile profile;                    ///< envelope of revolution about z
  PointShell shell;                   ///< of the envelope (`spin: envelope`) or of the mesh (`spin: resolved`)
  Aabb bounds;                        ///< of the shell's surface, T, mm
  double reach_mm = 0;                ///< farthest shell point from the origin of T
  bool revolved = false;              ///< the mesh is a surface of revolution: the profile's
  std::optional<DistanceGrid> teeth;  ///< distance to the mesh, where `erosion: exact` clips by it (clipped_tool.h)

  /// A surface that clips may lie so far outside the profile.
  [[nodiscard]] double clip_slack_mm() const { return teeth ? teeth->slack_mm : 0; }
  /// Holds every surface that clips, T, mm.
  [[nodiscard]] Aabb clip_bounds() const { return profile.bounds().expanded(clip_slack_mm()); }
};

/// What a run does with the tool's point shell.
enum class ShellUse {
  touches_voxels,  ///< its points find the voxels that go, so that a coarse one leaves bone behind
  extent,          ///< it only says how far the tool reaches: voxels are found by the surface itself
};

/// Reads the mesh, finds its envelope of revolution and samples its surface.
/// `voxel_mm` sets the shell's resolution where the scenario leaves it open (spacing ≤ half a voxel), and is what the
/// spacing is judged against otherwise: a leaking combination gets a warning where the shell touches voxels.
/// Throws InputError: unreadable or open mesh, no axis of revolution, a shell of more than 4096³ cells that has to
/// touch voxels.
Tool load_tool(const ToolSettings& settings, double voxel_mm, ShellUse use, Report& report);

}  // namespace reamsim
