// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/voxmap/sample_voxels.h"

#include <cmath>

#include "sim/base/parallel.h"

namespace reamsim {

namespace {

constexpr std::size_t kBricksAtOnce = 1 << 10;

struct ChangedVoxel {
  std::uint16_t offset;  ///< in its brick
  std::uint16_t fill;
  std::uint8_t grade;
};

struct ChangedBrick {
  Vec3i coord;
  std::vector<ChangedVoxel> voxels;
};

/// Which voxels of a brick lie at the surface: the 3×3×3 voxels around them are neither all bone nor all air.
class SurfaceOfBrick {
 public:
  SurfaceOfBrick(const GradeBricks& grades, const Vec3i& brick)
      : bone_(grades, nullptr, brick,
              [](const auto& stored, const auto*, std::size_t at) -> std::uint8_t { return stored[at] != 0 ? 1 : 0; }) {
    any_ = all_ = bone_.values();
    if (!mixed()) return;
    // Combines each voxel with its two neighbours along one axis. The values on the border are not used.
    for (int axis = 0; axis < 3; ++axis) {
      const std::size_t stride = Padded::place(Vec3i::Unit(axis)) - Padded::place(Vec3i::Zero());
      const Padded::Values any = any_, all = all_;
      for (std::size_t i = stride; i + stride < any.size(); ++i) {
        any_[i] = any[i - stride] | any[i] | any[i + stride];
        all_[i] = all[i - stride] & all[i] & all[i + stride];
      }
    }
  }

  [[nodiscard]] bool mixed() const { return bone_.least() != bone_.most(); }
  [[nodiscard]] bool contains(const Vec3i& voxel) const {
    const std::size_t at = Padded::place(voxel);
    return any_[at] != 0 && all_[at] == 0;
  }

 private:
  using Padded = PaddedBrick<std::uint8_t>;

  Padded bone_;
  Padded::Values any_, all_;
};

ChangedBrick sample_surface_of(const SurfaceSampler& sample, const Voxmap& voxmap, const Vec3i& coord) {
  ChangedBrick out{coord, {}};
  const SurfaceOfBrick surface(voxmap.grade, coord);
  if (!surface.mixed()) return out;
  for (int offset = 0; offset < BrickLattice::kVoxels; ++offset) {
    if (!surface.contains(BrickLattice::voxel_at(Vec3i::Zero(), offset))) continue;
    const Vec3i voxel = BrickLattice::voxel_at(coord, offset);
    if (!voxmap.grid.contains(voxel)) continue;
    const std::uint8_t grade = voxmap.grade.get(voxel);
    const SurfaceVoxel found = sample(voxel, grade);
    const double fraction = std::clamp(found.fraction, 0.0, 1.0);
    const auto fill = static_cast<std::uint16_t>(std::lround(fraction * FillBricks::kWhole));
    if (fill == (grade == 0 ? 0 : FillBricks::kWhole)) continue;
    out.voxels.push_back({static_cast<std::uint16_t>(offset), fill, found.grade});
  }
  return out;
}

/// The bricks whose fill changes.
std::vector<ChangedBrick> sample_surface(const SurfaceSampler& sample, const Voxmap& voxmap) {
  std::vector<ChangedBrick> out;
  for (const Vec3i& coord : bricks_near_bone(voxmap.grade)) {
    if (voxmap.grade.lattice().contains(coord)) out.push_back({coord, {}});
  }
  parallel_items(out.size(), [&](std::size_t i) { out[i] = sample_surface_of(sample, voxmap, out[i].coord); });
  std::erase_if(out, [](const ChangedBrick& brick) { return brick.voxels.empty(); });
  return out;
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
  for (const ChangedBrick& brick : sample_surface(sample, voxmap)) {
    FillBricks::Brick fill;
    fill.fill(FillBricks::kWhole);
    for (const ChangedVoxel& changed : brick.voxels) {
      if (changed.fill != 0) fill[changed.offset] = changed.fill;  // air is whole everywhere
      voxmap.grade.set(BrickLattice::voxel_at(brick.coord, changed.offset), changed.fill == 0 ? 0 : changed.grade);
    }
    voxmap.fill.put(brick.coord, fill);
  }
}

}  // namespace reamsim
