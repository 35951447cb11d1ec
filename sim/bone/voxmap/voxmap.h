// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/bone/voxmap/density.h"
#include "sim/bone/voxmap/sparse_bricks.h"
#include "sim/bone/voxmap/voxel_grid.h"

namespace reamsim {

/// The two layers of a mesh bone: cortical down to a depth below its surface, trabecular below. Pictures draw their
/// boundary without voxel steps.
struct BoneLayers {
  double cortical_mm;
  double cortical_g_cm3;
  double trabecular_g_cm3;
};

/// The bone before reaming, as voxels (paper §3.2: the voxmap). Immutable once it is built.
struct Voxmap {
  VoxelGrid grid;
  GradeBricks grade;  ///< density of each voxel; 0 = air
  DensityMapping mapping;
  std::string frame = "LPS";  ///< the bone frame B: "LPS" for CT, "mesh" for a mesh, "phantom"
  std::optional<BoneLayers> layers;

  Voxmap() = default;
  /// All air.
  explicit Voxmap(const VoxelGrid& lattice) : grid(lattice), grade(lattice.dims) {}

  /// False outside the lattice.
  [[nodiscard]] bool is_bone(const Vec3i& voxel) const { return grid.contains(voxel) && grade.get(voxel) != 0; }
};

/// A bone for reading: its voxmap, and the current fill of each voxel. Both must outlive the view.
struct BoneView {
  const Voxmap& voxmap;
  const FillBricks& fill;

  BoneView(const Voxmap& voxels, const FillBricks& current) : voxmap(voxels), fill(current) {}

  /// Voxels with remaining bone: grade ≠ 0 and fill ≠ 0.
  [[nodiscard]] std::int64_t count_bone() const;
  /// Remaining bone, mm³: Σ fill/65535 · voxel volume over voxels with grade ≠ 0.
  [[nodiscard]] double bone_mm3() const;
};

/// Removed voxels and the frames of their removal: (voxel index, frame), unordered.
using RemovedFrames = std::vector<std::pair<std::int64_t, std::int32_t>>;

/// A voxmap and the fill of its voxels, while a bone is built or read from a file.
struct FilledVoxmap : Voxmap {
  FillBricks fill;  ///< undefined where the grade is 0

  FilledVoxmap() = default;
  /// All voxels are air and whole.
  explicit FilledVoxmap(const VoxelGrid& lattice) : Voxmap(lattice), fill(lattice.dims) {}

  operator BoneView() const { return {*this, fill}; }  // not explicit on purpose
  [[nodiscard]] std::int64_t count_bone() const { return BoneView(*this, fill).count_bone(); }
  [[nodiscard]] double bone_mm3() const { return BoneView(*this, fill).bone_mm3(); }
};

/// Calls visit(voxel, grade, fill) for the voxels with grade ≠ 0 of a stored brick.
template <class Visit>
void for_each_bone_voxel_in(const BoneView& bone, const Vec3i& coord, const Visit& visit) {
  const GradeBricks::Brick& grades = *bone.voxmap.grade.brick(coord);
  const FillBricks::Brick* fill = bone.fill.brick(coord);
  for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
    const auto at = static_cast<std::size_t>(offset);
    if (grades[at] == 0) continue;
    visit(BrickLattice::voxel_at(coord, offset), grades[at], fill == nullptr ? FillBricks::kWhole : (*fill)[at]);
  }
}
/// The same for all bricks.
template <class Visit>
void for_each_bone_voxel(const BoneView& bone, const Visit& visit) {
  bone.voxmap.grade.for_each_brick(
      [&](const Vec3i& coord, const GradeBricks::Brick&) { for_each_bone_voxel_in(bone, coord, visit); });
}

/// The first and the last voxel of a box, both included; first > last in an empty box.
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

/// The bricks that contain bone and their 26 neighbours, x fastest. They may lie one brick outside the lattice.
std::vector<Vec3i> bricks_near_bone(const GradeBricks& grades);

/// Whether some voxel is partly filled: neither whole nor removed.
bool partly_filled(const FillBricks& fill);

/// The grade of each voxel with remaining bone, 0 elsewhere; grid.size() entries, for engines with dense storage.
std::vector<std::uint8_t> dense_remaining_grades(const BoneView& bone);
/// The fill of each voxel, air included; grid.size() entries.
std::vector<std::uint16_t> dense_fill(const BoneView& bone);

/// The stages in which a bone is loaded, and written by `reamsim import`. A CT has all but `distances`, a mesh `read`,
/// `distances`, `voxels` and `anatomy`, a VDB `read` and `anatomy`, a phantom `voxels` and `anatomy`.
enum class BoneStage { read, filter, segment, correct_density, distances, voxels, anatomy, write };

/// Called when a stage begins. May be empty.
using StageSink = std::function<void(BoneStage)>;

inline void begin_stage(const StageSink& sink, BoneStage stage) {
  if (sink) sink(stage);
}

}  // namespace reamsim
