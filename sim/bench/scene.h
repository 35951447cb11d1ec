#pragma once

#include "sim/bone/voxmap/voxmap.h"
#include "sim/engine/common/substep.h"
#include "sim/tool/tool.h"

namespace reamsim::bench {

/// Edge of the cube of bone, mm; the same at every resolution. Frame B of the glenoid phantom: +x lateral out of the
/// face, +z superior, origin at the face's centre.
inline constexpr double kBoxMm = 40;
/// Radius of the hemispherical reamer, mm.
inline constexpr double kReamerMm = 14;

/// The glenoid phantom over `side`³ voxels of the same cube. It is sampled once, at 256³; finer voxmaps divide its
/// voxels with interpolation and coarser ones merge them with averaging, as the paper resizes its CT.
class BoneSeries {
 public:
  /// `sampled`: voxels along an edge where the phantom itself is sampled; a power of two.
  explicit BoneSeries(int sampled = 256);

  /// `side`: a power of two. Takes no more than a few seconds at 1024.
  [[nodiscard]] FilledVoxmap at(int side) const;
  /// The box of the bone in B, mm, as the broad phase sees it at this resolution.
  [[nodiscard]] Aabb box(int side) const;

 private:
  FilledVoxmap sampled_;
  Aabb box_mm_;
};

/// The reamer's hemispherical cap without a lid, sampled in a `resolution`³ grid that spans the whole scanned reamer:
/// the cap takes kCapShare of its edge, which gives the paper's number of points at every resolution.
inline constexpr double kCapShare = 0.6945;
Tool cap_tool(int resolution);

/// Box of the shell's points, T, mm; half a cell beyond the surface.
Aabb shell_box(const Tool& tool);

/// Cutting as the program does it by default.
CuttingSettings bench_cutting();

}  // namespace reamsim::bench
