// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/voxmap/sample_voxels.h"

#include <cmath>

#include "sim/base/parallel.h"

namespace reamsim {

namespace {

constexpr std::size_t kBricksAtOnce = 1 << 10;

struct SurfaceBrick {
  GradeBricks::Brick grades;
  FillBricks::Brick fill;
};

/// Which voxels of a brick lie at the surface: the 3×3×3 voxels around them are neither all bone nor all air.
class SurfaceOfBrick {
 public:
  SurfaceOfBrick(const GradeBricks& grades, const Vec3i& brick)
      : bone_(grades, nullptr, brick,
              [](const auto& stored, const auto*, std::size_t at) -> std::uint8_t { return stored[at] != 0 ? 1 : 0; }) {
    any_ = all_ = bone_.values();
    if (mixed()) {
      for (int axis = 0; axis < 3; ++axis)
        include_neighbours(Padded::place(Vec3i::Unit(axis)) - Padded::place(Vec3i::Zero()));
    }
  }

  [[nodiscard]] bool mixed() const { return bone_.least() != bone_.most(); }
  [[nodiscard]] bool contains(const Vec3i& voxel) const {
    const std::size_t at = Padded::place(voxel);
    return any_[at] != 0 && all_[at] == 0;
  }

 private:
  using Padded = PaddedBrick<std::uint8_t>;

  /// Combines each voxel with its two neighbours along one axis. The values on the border are not used.
  void include_neighbours(std::size_t stride) {
    const Padded::Values any = any_, all = all_;
    for (std::size_t i = stride; i + stride < any.size(); ++i) {
      any_[i] = any[i - stride] | any[i] | any[i + stride];
      all_[i] = all[i - stride] & all[i] & all[i + stride];
    }
  }

  Padded bone_;
  Padded::Values any_, all_;
};

/// Sets a brick whose grades are `before`. Air is whole everywhere.
void sample_surface_of(const SurfaceSampler& sample, const VoxelGrid& grid, const GradeBricks& before,
                       const Vec3i& coord, SurfaceBrick& out) {
  const GradeBricks::Brick* stored = before.brick(coord);
  out.grades = stored == nullptr ? GradeBricks::Brick{} : *stored;
  out.fill.fill(FillBricks::kWhole);
  const SurfaceOfBrick surface(before, coord);
  if (!surface.mixed()) return;
  for (int offset = 0; offset < BrickLattice::kVoxels; ++offset) {
    const Vec3i voxel = BrickLattice::voxel_at(coord, offset);
    if (!surface.contains(BrickLattice::voxel_at(Vec3i::Zero(), offset)) || !grid.contains(voxel)) continue;
    const auto at = static_cast<std::size_t>(offset);
    std::uint8_t& grade = out.grades[at];
    const SurfaceVoxel found = sample(voxel, grade);
    const double fraction = std::clamp(found.fraction, 0.0, 1.0);
    const auto fill = static_cast<std::uint16_t>(std::lround(fraction * FillBricks::kWhole));
    if (fill == (grade == 0 ? 0 : FillBricks::kWhole)) continue;
    grade = fill == 0 ? 0 : found.grade;
    if (fill != 0) out.fill[at] = fill;
  }
}

}  // namespace

GradeBricks sample_bricks(const Vec3i& dims, const BrickSampler& sample) {
  GradeBricks out(dims);
  const BrickLattice& bricks = out.lattice();
  parallel_in_order<GradeBricks::Brick>(
      bricks.count(), kBricksAtOnce,
      [&](std::size_t i, GradeBricks::Brick& brick) {
        brick.fill(0);
        sample(bricks.coord(i), brick);
      },
      [&](std::size_t i, const GradeBricks::Brick& brick) { out.put(bricks.coord(i), brick); });
  return out;
}

void set_partial_fill(const SurfaceSampler& sample, FilledVoxmap& voxmap) {
  const GradeBricks before = voxmap.grade;  // the surface is that before any voxel changes
  std::vector<Vec3i> bricks = bricks_near_bone(before);
  std::erase_if(bricks, [&](const Vec3i& coord) { return !before.lattice().contains(coord); });
  parallel_in_order<SurfaceBrick>(
      bricks.size(), kBricksAtOnce,
      [&](std::size_t i, SurfaceBrick& brick) { sample_surface_of(sample, voxmap.grid, before, bricks[i], brick); },
      [&](std::size_t i, const SurfaceBrick& brick) {
        voxmap.grade.put(bricks[i], brick.grades);
        voxmap.fill.put(bricks[i], brick.fill);
      });
}

}  // namespace reamsim
