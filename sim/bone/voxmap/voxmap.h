#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/bone/voxmap/density.h"
#include "sim/bone/voxmap/fill_bricks.h"
#include "sim/bone/voxmap/grade_bricks.h"
#include "sim/bone/voxmap/voxel_grid.h"

namespace reamsim {

/// The bone as voxels (paper §3.2: the voxmap). `grade` is the density of the unreamed bone and never changes in a
/// run; `fill` is what is left of each voxel.
struct Voxmap {
  VoxelGrid grid;
  GradeBricks grade;  ///< 0 = air
  FillBricks fill;
  DensityMapping mapping;
  std::string frame = "LPS";  ///< the bone frame B: "LPS" for CT, "mesh" for a mesh, "phantom"

  Voxmap() = default;
  /// All air, all whole.
  explicit Voxmap(const VoxelGrid& lattice) : grid(lattice), grade(lattice.dims), fill(lattice.dims) {}

  /// Voxels with bone left: grade ≠ 0 and fill ≠ 0.
  [[nodiscard]] std::int64_t count_bone() const;
  /// Bone volume left, mm³: Σ fill/65535 · voxel volume over voxels with grade ≠ 0.
  [[nodiscard]] double bone_mm3() const;
};

/// Calls visit(voxel, grade, fill) for every voxel with grade ≠ 0, brick by brick.
template <class Visit>
void for_each_bone_voxel(const Voxmap& voxmap, const Visit& visit) {
  voxmap.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick& grades) {
    const FillBricks::Brick* fill = voxmap.fill.brick(coord);
    for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
      const auto at = static_cast<std::size_t>(offset);
      if (grades[at] == 0) continue;
      visit(BrickLattice::voxel_at(coord, offset), grades[at], fill == nullptr ? FillBricks::kWhole : (*fill)[at]);
    }
  });
}

/// The first and the last voxel of a box, both inside; first > last where it is empty.
struct VoxelBox {
  Vec3i first;
  Vec3i last;

  [[nodiscard]] bool empty() const { return (first.array() > last.array()).any(); }
  /// Voxels along each axis; 0, 0, 0 for an empty box.
  [[nodiscard]] Vec3i size() const { return empty() ? Vec3i(Vec3i::Zero()) : Vec3i(last - first + Vec3i::Ones()); }
  [[nodiscard]] bool contains(const Vec3i& voxel) const {
    return (voxel.array() >= first.array()).all() && (voxel.array() <= last.array()).all();
  }
};

/// The box of the voxels with grade ≠ 0.
VoxelBox bone_extent(const Voxmap& voxmap);

/// The grade of each voxel where bone is left, 0 elsewhere; grid.size() entries, for engines that keep the bone dense.
std::vector<std::uint8_t> dense_grades_left(const Voxmap& voxmap);
/// The fill of each voxel, air included; grid.size() entries.
std::vector<std::uint16_t> dense_fill(const Voxmap& voxmap);

}  // namespace reamsim
