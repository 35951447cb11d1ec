#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/bone/density.h"
#include "sim/bone/fill_bricks.h"
#include "sim/bone/voxel_grid.h"

namespace reamsim {

/// The bone as voxels (paper §3.2: the voxmap). `grade` is the density of the unreamed bone and never changes in a
/// run; `fill` is what is left of each voxel.
struct Voxmap {
  VoxelGrid grid;
  std::vector<std::uint8_t> grade;  ///< grid.size() entries, 0 = air
  FillBricks fill;
  DensityMapping mapping;
  std::string frame = "LPS";  ///< the bone frame B: "LPS" for CT, "mesh" for a mesh, "phantom"

  Voxmap() = default;
  /// All air, all whole.
  explicit Voxmap(const VoxelGrid& lattice)
      : grid(lattice), grade(static_cast<std::size_t>(lattice.size()), 0), fill(lattice.dims) {}

  /// Voxels with bone left: grade ≠ 0 and fill ≠ 0.
  [[nodiscard]] std::int64_t count_bone() const;
  /// Bone volume left, mm³: Σ fill/65535 · voxel volume over voxels with grade ≠ 0.
  [[nodiscard]] double bone_mm3() const;
};

}  // namespace reamsim
