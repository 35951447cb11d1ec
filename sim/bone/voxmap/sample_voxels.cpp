// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/voxmap/sample_voxels.h"

#include <cmath>

#include "sim/base/parallel.h"

namespace reamsim {

namespace {

/// Rows of bricks that are sampled before they are stored: enough work for many threads, little memory.
constexpr int kRowsAtOnce = 256;

/// A brick with bone, and its coordinate along x.
struct SampledBrick {
  int x;
  GradeBricks::Brick grades;
};

std::vector<SampledBrick> sample_row(const Vec3i& first, int count, const BrickSampler& sample) {
  std::vector<SampledBrick> out;
  SampledBrick next{0, {}};
  for (; next.x < count; ++next.x) {
    if (!sample({next.x, first.y(), first.z()}, next.grades)) continue;
    out.push_back(next);
    next.grades.fill(0);
  }
  return out;
}

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
  const BrickLattice lattice{voxmap.grade.brick_dims()};
  std::vector<ChangedBrick> out;
  for (const Vec3i& coord : bricks_near_bone(voxmap.grade)) {
    if (lattice.contains(coord)) out.push_back({coord, {}});
  }
  parallel_items(out.size(), [&](std::size_t i) { out[i] = sample_surface_of(sample, voxmap, out[i].coord); });
  std::erase_if(out, [](const ChangedBrick& brick) { return brick.voxels.empty(); });
  return out;
}

}  // namespace

GradeBricks sample_bricks(const Vec3i& dims, const BrickSampler& sample) {
  GradeBricks out(dims);
  const Vec3i bricks = out.brick_dims();
  const auto coord = [&bricks](std::int64_t row) {
    return Vec3i(0, static_cast<int>(row % bricks.y()), static_cast<int>(row / bricks.y()));
  };
  const std::int64_t rows = std::int64_t{bricks.y()} * bricks.z();
  std::vector<std::vector<SampledBrick>> sampled(kRowsAtOnce);
  for (std::int64_t first = 0; first < rows; first += kRowsAtOnce) {
    const std::int64_t count = std::min<std::int64_t>(kRowsAtOnce, rows - first);
    parallel_items(static_cast<std::size_t>(count), [&](std::size_t i) {
      sampled[i] = sample_row(coord(first + static_cast<std::int64_t>(i)), bricks.x(), sample);
    });
    // One thread stores them in the order of the lattice, so that the slots are the same in every run.
    for (std::int64_t i = 0; i < count; ++i) {
      for (const SampledBrick& brick : sampled[static_cast<std::size_t>(i)]) {
        out.put(coord(first + i) + Vec3i(brick.x, 0, 0), brick.grades);
      }
    }
  }
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
