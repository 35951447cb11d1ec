#include "sim/bone/voxmap/surface_voxels.h"

#include <algorithm>
#include <cmath>

#include "sim/base/parallel.h"

namespace reamsim {

namespace {

constexpr int kSide = BrickLattice::kSide;
constexpr int kPaddedSide = kSide + 2;
constexpr std::size_t kBricksAtOnce = 16;

/// A voxel that is no longer as it was.
struct ChangedVoxel {
  std::uint16_t offset;  ///< in its brick
  std::uint16_t fill;
  std::uint8_t grade;
};

struct ChangedBrick {
  Vec3i coord;
  std::vector<ChangedVoxel> voxels;
};

std::size_t padded_index(int x, int y, int z) {
  return static_cast<std::size_t>(x + kPaddedSide * (y + kPaddedSide * z));
}

/// Which voxels of a brick, and of one voxel all round it, are bone; air outside the lattice.
class BoneAbout {
 public:
  BoneAbout(const GradeBricks& grades, const Vec3i& brick) {
    const BrickLattice lattice{grades.brick_dims()};
    for (int part = 0; part < 27; ++part) {
      const Vec3i step(part % 3 - 1, part / 3 % 3 - 1, part / 9 - 1);
      const Vec3i coord = brick + step;
      const GradeBricks::Brick* from = lattice.contains(coord) ? grades.brick(coord) : nullptr;
      if (from != nullptr) copy_from_neighbour(*from, step);
    }
    mixed_ = some_ < bone_.size() && some_ > 0;
    if (mixed_) {
      any_ = all_ = bone_;
      for (const std::size_t stride : {padded_index(1, 0, 0), padded_index(0, 1, 0), padded_index(0, 0, 1)}) {
        spread(stride);
      }
    }
  }

  [[nodiscard]] bool mixed() const { return mixed_; }
  /// Whether the 27 voxels round a voxel of the brick are neither all bone nor all air.
  [[nodiscard]] bool at_surface(const Vec3i& voxel) const {
    const std::size_t at = padded_index(voxel.x() + 1, voxel.y() + 1, voxel.z() + 1);
    return any_[at] != 0 && all_[at] == 0;
  }

 private:
  using Marks = std::array<std::uint8_t, kPaddedSide * kPaddedSide * kPaddedSide>;

  void copy_from_neighbour(const GradeBricks::Brick& from, const Vec3i& step) {
    const Vec3i low = step.unaryExpr([](int s) { return s < 0 ? kSide - 1 : 0; });
    const Vec3i high = step.unaryExpr([](int s) { return s > 0 ? 1 : kSide; });
    for (int z = low.z(); z < high.z(); ++z) {
      for (int y = low.y(); y < high.y(); ++y) {
        for (int x = low.x(); x < high.x(); ++x) {
          const Vec3i to = Vec3i(x, y, z) + kSide * step + Vec3i::Ones();
          const auto bone = static_cast<std::uint8_t>(
              from[static_cast<std::size_t>(BrickLattice::offset_of({x, y, z}))] != 0 ? 1 : 0);
          bone_[padded_index(to.x(), to.y(), to.z())] = bone;
          some_ += bone;
        }
      }
    }
  }
  /// Takes in the neighbours along one axis; values at the rim are not used.
  void spread(std::size_t stride) {
    const Marks any = any_, all = all_;
    for (std::size_t i = stride; i + stride < any.size(); ++i) {
      any_[i] = any[i - stride] | any[i] | any[i + stride];
      all_[i] = all[i - stride] & all[i] & all[i + stride];
    }
  }

  Marks bone_{}, any_{}, all_{};
  std::size_t some_ = 0;
  bool mixed_ = false;
};

ChangedBrick sample_brick(const SurfaceSampler& sample, const Voxmap& voxmap, const Vec3i& coord) {
  ChangedBrick out{coord, {}};
  const BoneAbout about(voxmap.grade, coord);
  if (!about.mixed()) return out;
  for (int offset = 0; offset < BrickLattice::kVoxels; ++offset) {
    if (!about.at_surface(BrickLattice::voxel_at(Vec3i::Zero(), offset))) continue;
    const Vec3i voxel = BrickLattice::voxel_at(coord, offset);
    if (!voxmap.grid.contains(voxel)) continue;
    const std::uint8_t grade = voxmap.grade.get(voxel);
    const SurfaceVoxel found = sample(voxel, grade);
    const auto fill =
        static_cast<std::uint16_t>(std::lround(std::clamp(found.fraction, 0.0, 1.0) * FillBricks::kWhole));
    if (fill == (grade == 0 ? 0 : FillBricks::kWhole)) continue;
    out.voxels.push_back({static_cast<std::uint16_t>(offset), fill, found.grade});
  }
  return out;
}

/// Bricks of the lattice that the surface may pass, each with what changes in it.
std::vector<ChangedBrick> sample_surface(const SurfaceSampler& sample, const Voxmap& voxmap) {
  const BrickLattice lattice{voxmap.grade.brick_dims()};
  std::vector<ChangedBrick> out;
  for (const Vec3i& coord : bricks_near_bone(voxmap.grade)) {
    if (lattice.contains(coord)) out.push_back({coord, {}});
  }
  parallel_ranges(out.size(), kBricksAtOnce, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) out[i] = sample_brick(sample, voxmap, out[i].coord);
  });
  std::erase_if(out, [](const ChangedBrick& brick) { return brick.voxels.empty(); });
  return out;
}

void put_fill(const std::vector<ChangedBrick>& changed, FilledVoxmap& voxmap) {
  for (const ChangedBrick& brick : changed) {
    FillBricks::Brick fill;
    fill.fill(FillBricks::kWhole);
    for (const ChangedVoxel& voxel : brick.voxels) fill[voxel.offset] = voxel.fill;
    voxmap.fill.put(brick.coord, fill);
  }
}

}  // namespace

void set_partial_fill(const SurfaceSampler& sample, FilledVoxmap& voxmap) {
  std::vector<ChangedBrick> changed = sample_surface(sample, voxmap);
  put_fill(changed, voxmap);
  for (const ChangedBrick& brick : changed) {
    for (const ChangedVoxel& changed_voxel : brick.voxels) {
      const Vec3i voxel = BrickLattice::voxel_at(brick.coord, changed_voxel.offset);
      voxmap.grade.set(voxel, changed_voxel.fill == 0 ? std::uint8_t{0} : changed_voxel.grade);
      if (changed_voxel.fill == 0) voxmap.fill.set(voxel, FillBricks::kWhole);  // air, as all air
    }
  }
}

}  // namespace reamsim
