#include "render/surface/ambient_occlusion.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/base/parallel.h"

namespace reamsim {
namespace {

constexpr int kFinestCell = 4;  // voxels
constexpr int kLevels = 4;
constexpr std::array kDistances_mm{1.2F, 2.5F, 5.0F, 10.0F};
constexpr std::array kWeights{0.30F, 0.30F, 0.25F, 0.15F};

/// Directions of the hemisphere round z: straight up, and five that lean over.
const std::array<Eigen::Vector3f, 6>& directions() {
  static const std::array<Eigen::Vector3f, 6> all = [] {
    std::array<Eigen::Vector3f, 6> out;
    out[0] = Eigen::Vector3f::UnitZ();
    for (std::size_t i = 0; i < 5; ++i) {
      const float turn = static_cast<float>(i) * 1.2566371F;
      out[i + 1] = Eigen::Vector3f(0.82F * std::cos(turn), 0.82F * std::sin(turn), 0.57F).normalized();
    }
    return out;
  }();
  return all;
}

}  // namespace

float& AmbientOcclusion::Level::at(const Vec3i& cell) {
  return fractions[static_cast<std::size_t>(cell.x() +
                                            std::int64_t{dims.x()} * (cell.y() + std::int64_t{dims.y()} * cell.z()))];
}

float AmbientOcclusion::Level::get(int x, int y, int z) const {
  if (x < 0 || y < 0 || z < 0 || x >= dims.x() || y >= dims.y() || z >= dims.z()) return 0;
  return fractions[static_cast<std::size_t>(x + std::int64_t{dims.x()} * (y + std::int64_t{dims.y()} * z))];
}

float AmbientOcclusion::Level::sample(const Eigen::Vector3f& point) const {
  // Voxel (0,0,0) has its centre at 0, so the first cell has its centre at (cell − 1)/2.
  const auto cell = static_cast<float>(cell_voxels);
  const Eigen::Vector3f p = (point.array() - 0.5F * (cell - 1)) / cell;
  const Eigen::Vector3f base = p.array().floor();
  const Eigen::Vector3f t = p - base;
  const Vec3i c = base.cast<int>();
  if ((c.array() >= 0).all() && (c.array() + 1 < dims.array()).all()) return inside(c, t);
  const auto along_x = [&](int y, int z) {
    return (1 - t.x()) * get(c.x(), c.y() + y, c.z() + z) + t.x() * get(c.x() + 1, c.y() + y, c.z() + z);
  };
  const float low = (1 - t.y()) * along_x(0, 0) + t.y() * along_x(1, 0);
  const float high = (1 - t.y()) * along_x(0, 1) + t.y() * along_x(1, 1);
  return (1 - t.z()) * low + t.z() * high;
}

float AmbientOcclusion::Level::inside(const Vec3i& c, const Eigen::Vector3f& t) const {
  const float* corner =
      &fractions[static_cast<std::size_t>(c.x() + std::int64_t{dims.x()} * (c.y() + std::int64_t{dims.y()} * c.z()))];
  const std::ptrdiff_t row = dims.x();
  const std::ptrdiff_t layer = row * dims.y();
  const auto along_x = [&](const float* at) { return (1 - t.x()) * at[0] + t.x() * at[1]; };
  const float low = (1 - t.y()) * along_x(corner) + t.y() * along_x(corner + row);
  const float high = (1 - t.y()) * along_x(corner + layer) + t.y() * along_x(corner + layer + row);
  return (1 - t.z()) * low + t.z() * high;
}

AmbientOcclusion::AmbientOcclusion(const Occupancy& occupancy) : voxel_mm_(occupancy.voxmap().grid.voxel_mm) {
  const Vec3i voxels = occupancy.brick_dims() * FillBricks::kSide;
  for (int level = 0; level < kLevels; ++level) {
    const int cell = kFinestCell << level;
    const Vec3i dims = (voxels.array() + cell - 1) / cell;
    levels_.push_back(
        {cell, dims,
         std::vector<float>(static_cast<std::size_t>(std::int64_t{1} * dims.x() * dims.y() * dims.z()), 0.0F)});
  }
  const Vec3i bricks = occupancy.brick_dims();
  parallel_items(static_cast<std::size_t>(bricks.z()), [&](std::size_t layer) {
    const int z = static_cast<int>(layer);
    for (int y = 0; y < bricks.y(); ++y) {
      for (int x = 0; x < bricks.x(); ++x) average_brick(occupancy, {x, y, z});
    }
  });
  average_coarse();
}

void AmbientOcclusion::update(const Occupancy& occupancy, const std::vector<Vec3i>& bricks) {
  for (const Vec3i& brick : bricks) average_brick(occupancy, brick);
  average_coarse();
}

void AmbientOcclusion::average_brick(const Occupancy& occupancy, const Vec3i& brick) {
  constexpr int kSide = FillBricks::kSide;
  constexpr int kHalves = kSide / kFinestCell;
  std::array<float, kHalves * kHalves * kHalves> sums{};
  const Occupancy::Kind kind = occupancy.kind(brick);
  if (kind == Occupancy::Kind::kFull) sums.fill(1);
  if (kind == Occupancy::Kind::kMixed) {
    std::array<float, FillBricks::kVoxels> fractions;
    occupancy.gather(brick * kSide, kSide, fractions.data());
    constexpr float kEach = 1.0F / (kFinestCell * kFinestCell * kFinestCell);
    for (int i = 0; i < FillBricks::kVoxels; ++i) {
      const int cell = (i % kSide) / kFinestCell +
                       kHalves * ((i / kSide % kSide) / kFinestCell + kHalves * (i / (kSide * kSide) / kFinestCell));
      sums[static_cast<std::size_t>(cell)] += kEach * fractions[static_cast<std::size_t>(i)];
    }
  }
  for (int i = 0; i < kHalves * kHalves * kHalves; ++i) {
    levels_[0].at(brick * kHalves + Vec3i(i % kHalves, i / kHalves % kHalves, i / (kHalves * kHalves))) =
        sums[static_cast<std::size_t>(i)];
  }
}

void AmbientOcclusion::average_coarse() {
  for (std::size_t level = 1; level < levels_.size(); ++level) {
    const Level& fine = levels_[level - 1];
    Level& coarse = levels_[level];
    parallel_items(static_cast<std::size_t>(coarse.dims.z()), [&](std::size_t layer) {
      const int z = static_cast<int>(layer);
      for (int y = 0; y < coarse.dims.y(); ++y) {
        for (int x = 0; x < coarse.dims.x(); ++x) {
          float sum = 0;
          for (int i = 0; i < 8; ++i) sum += fine.get(2 * x + (i & 1), 2 * y + (i >> 1 & 1), 2 * z + (i >> 2));
          coarse.at({x, y, z}) = sum / 8;
        }
      }
    });
  }
}

AmbientOcclusion::Probe AmbientOcclusion::probe_at(std::size_t distance) const {
  const float reach = kDistances_mm[distance] / static_cast<float>(voxel_mm_);
  // A cell no wider than about half the distance holds nothing of the flat face that the point lies on.
  const int wanted = std::ilogb(std::max(reach * 0.5F / kFinestCell, 1.0F));
  const Level& level = levels_[static_cast<std::size_t>(std::clamp(wanted, 0, kLevels - 1))];
  return {&level, std::max(reach, 1.5F * static_cast<float>(level.cell_voxels))};
}

double AmbientOcclusion::reach_voxels() const {
  double most = 0;
  for (std::size_t i = 0; i < kDistances_mm.size(); ++i) {
    const Probe probe = probe_at(i);
    // A sample mixes cells whose centres are up to a cell away.
    most = std::max(most, probe.offset + 1.5 * probe.level->cell_voxels);
  }
  return most;
}

float AmbientOcclusion::accessibility(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) const {
  const Eigen::Vector3f helper = std::abs(normal.x()) < 0.7F ? Eigen::Vector3f::UnitX() : Eigen::Vector3f::UnitY();
  const Eigen::Vector3f u = normal.cross(helper).normalized();
  const Eigen::Vector3f v = normal.cross(u);
  float occluded = 0;
  for (std::size_t i = 0; i < kDistances_mm.size(); ++i) {
    const Probe probe = probe_at(i);
    const Level& level = *probe.level;
    float sum = 0;
    for (const Eigen::Vector3f& d : directions()) {
      sum += level.sample(point + probe.offset * (d.x() * u + d.y() * v + d.z() * normal));
    }
    occluded += kWeights[i] * sum / static_cast<float>(directions().size());
  }
  return 1 - occluded;
}

}  // namespace reamsim
