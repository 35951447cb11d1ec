// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <array>
#include <cmath>

#include "render/surface/bone_surface.h"
#include "sim/base/parallel.h"

namespace reamsim {
namespace {

constexpr int kBrickVoxels = FillBricks::kSide;  // along an edge
constexpr int kFinestCell = 4;                   // voxels
constexpr int kLevels = 4;
constexpr std::array kDistances_mm{1.2F, 2.5F, 5.0F, 10.0F};
constexpr std::array kWeights{0.30F, 0.30F, 0.25F, 0.15F};

/// Sample directions of the hemisphere about z: the pole and five inclined ones.
const std::array<Eigen::Vector3f, 6> kDirections = [] {
  std::array<Eigen::Vector3f, 6> out{Eigen::Vector3f::UnitZ()};
  for (std::size_t i = 0; i < 5; ++i) {
    const float angle = static_cast<float>(i) * 1.2566371F;
    out[i + 1] = Eigen::Vector3f(0.82F * std::cos(angle), 0.82F * std::sin(angle), 0.57F).normalized();
  }
  return out;
}();

}  // namespace

float AmbientOcclusion::Level::get(const Vec3i& cell) const {
  return cells.contains(cell) ? fractions[cells.index(cell)] : 0;
}

float AmbientOcclusion::Level::sample(const Eigen::Vector3f& point) const {
  // Voxel (0,0,0) has its centre at 0, so the first cell has its centre at (cell − 1)/2.
  const auto cell = static_cast<float>(cell_voxels);
  const Eigen::Vector3f p = (point.array() - 0.5F * (cell - 1)) * (1 / cell);  // a power of two: exact
  const auto below = [](float x) {
    return static_cast<int>(x) - (x < static_cast<float>(static_cast<int>(x)) ? 1 : 0);
  };
  const Vec3i c(below(p.x()), below(p.y()), below(p.z()));  // std::floor() calls the library
  const Eigen::Vector3f t = p - c.cast<float>();
  const auto trilinear = [&](const auto& at) {
    const auto along_x = [&](int y, int z) { return (1 - t.x()) * at(0, y, z) + t.x() * at(1, y, z); };
    const float low = (1 - t.y()) * along_x(0, 0) + t.y() * along_x(1, 0);
    const float high = (1 - t.y()) * along_x(0, 1) + t.y() * along_x(1, 1);
    return (1 - t.z()) * low + t.z() * high;
  };
  if (!cells.contains(c) || !cells.contains(c + Vec3i::Ones())) {
    return trilinear([&](int x, int y, int z) { return get(c + Vec3i(x, y, z)); });
  }
  const float* corner = &fractions[cells.index(c)];
  const std::ptrdiff_t row = cells.dims.x(), layer = row * cells.dims.y();
  return trilinear([&](int x, int y, int z) { return corner[x + y * row + z * layer]; });
}

AmbientOcclusion::AmbientOcclusion(const Occupancy& occupancy) {
  const Vec3i voxels = occupancy.brick_dims() * kBrickVoxels;
  for (int level = 0; level < kLevels; ++level) {
    const int cell = kFinestCell << level;
    const BrickLattice cells{(voxels.array() + cell - 1) / cell};
    levels_.push_back({cell, cells, std::vector<float>(cells.count(), 0.0F)});
  }
  for (std::size_t i = 0; i < kDistances_mm.size(); ++i) {
    const float reach = kDistances_mm[i] / static_cast<float>(occupancy.voxmap().grid.voxel_mm);
    // Cells up to half the distance wide do not reach the flat face that the point lies on.
    const int wanted = std::ilogb(std::max(reach * 0.5F / kFinestCell, 1.0F));
    const auto level = static_cast<std::size_t>(std::clamp(wanted, 0, kLevels - 1));
    probes_.push_back({level, std::max(reach, 1.5F * static_cast<float>(levels_[level].cell_voxels)), kWeights[i]});
  }
  const BrickLattice bricks{occupancy.brick_dims()};
  parallel_items(bricks.count(), 64, [&](std::size_t i) { average_brick(occupancy, bricks.coord(i)); });
  average_coarse();
}

void AmbientOcclusion::update(const Occupancy& occupancy, const std::vector<Vec3i>& bricks) {
  for (const Vec3i& brick : bricks) average_brick(occupancy, brick);
  average_coarse();
}

void AmbientOcclusion::average_brick(const Occupancy& occupancy, const Vec3i& brick) {
  constexpr int kHalves = kBrickVoxels / kFinestCell;
  std::array<float, kHalves * kHalves * kHalves> sums{};
  const Occupancy::Kind kind = occupancy.kind(brick);
  if (kind == Occupancy::Kind::kFull) sums.fill(1);
  if (kind == Occupancy::Kind::kMixed) {
    std::array<float, FillBricks::kVoxels> fractions{};
    occupancy.gather(brick * kBrickVoxels, kBrickVoxels, fractions.data());
    constexpr float kEach = 1.0F / (kFinestCell * kFinestCell * kFinestCell);
    for (int i = 0; i < FillBricks::kVoxels; ++i) {
      const int cell =
          (i % kBrickVoxels) / kFinestCell + kHalves * ((i / kBrickVoxels % kBrickVoxels) / kFinestCell +
                                                        kHalves * (i / (kBrickVoxels * kBrickVoxels) / kFinestCell));
      sums[static_cast<std::size_t>(cell)] += kEach * fractions[static_cast<std::size_t>(i)];
    }
  }
  for (int i = 0; i < kHalves * kHalves * kHalves; ++i) {
    const Vec3i cell = brick * kHalves + Vec3i(i % kHalves, i / kHalves % kHalves, i / (kHalves * kHalves));
    levels_[0].fractions[levels_[0].cells.index(cell)] = sums[static_cast<std::size_t>(i)];
  }
}

void AmbientOcclusion::average_coarse() {
  for (std::size_t level = 1; level < levels_.size(); ++level) {
    const Level& fine = levels_[level - 1];
    Level& coarse = levels_[level];
    parallel_items(coarse.fractions.size(), 512, [&](std::size_t i) {
      const Vec3i cell = 2 * coarse.cells.coord(i);
      float sum = 0;
      for (int n = 0; n < 8; ++n) sum += fine.get(cell + Vec3i(n & 1, n >> 1 & 1, n >> 2));
      coarse.fractions[i] = sum / 8;
    });
  }
}

double AmbientOcclusion::reach_voxels() const {
  double reach = 0;
  // Interpolation reads cells whose centres are up to one cell away.
  for (const Probe& probe : probes_) reach = std::max(reach, probe.offset + 1.5 * levels_[probe.level].cell_voxels);
  return reach;
}

float AmbientOcclusion::accessibility(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) const {
  const Eigen::Vector3f helper = std::abs(normal.x()) < 0.7F ? Eigen::Vector3f::UnitX() : Eigen::Vector3f::UnitY();
  const Eigen::Vector3f u = normal.cross(helper).normalized();
  const Eigen::Vector3f v = normal.cross(u);
  float occluded = 0;
  for (const Probe& probe : probes_) {
    float sum = 0;
    for (const Eigen::Vector3f& d : kDirections) {
      sum += levels_[probe.level].sample(point + probe.offset * (d.x() * u + d.y() * v + d.z() * normal));
    }
    occluded += probe.weight * sum / static_cast<float>(kDirections.size());
  }
  return 1 - occluded;
}

}  // namespace reamsim
