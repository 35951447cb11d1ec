// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

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

/// The glenoid phantom with `side`³ voxels in the same cube. It is sampled once, at 256³; finer voxmaps interpolate and
/// coarser ones average, as the paper resizes its CT.
class BoneSeries {
 public:
  /// `sampled`: voxels along an edge of the sampled phantom; a power of two.
  explicit BoneSeries(int sampled = 256);

  /// `side`: a power of two. Takes a few seconds at 1024.
  [[nodiscard]] FilledVoxmap at(int side) const;
  /// The box of the bone in B, mm, for the broad phase at this resolution.
  [[nodiscard]] Aabb box(int side) const;

 private:
  FilledVoxmap sampled_;
  Aabb box_mm_;
};

/// The hemispherical cap of the reamer without its lid, sampled in a `resolution`³ grid that spans the whole scanned
/// reamer. The cap spans kCapFraction of its edge, which gives the paper's number of points at every resolution.
inline constexpr double kCapFraction = 0.6945;
Tool cap_tool(int resolution);

/// Box of the shell points, T, mm: half a cell beyond the surface.
Aabb shell_box(const Tool& tool);

/// The program's default cutting settings with whole voxels removed.
CuttingSettings bench_cutting();

}  // namespace reamsim::bench
