#pragma once

#include <vector>

#include "render/surface/occupancy.h"

namespace reamsim {

/// Ambient occlusion of surface points, from the bone fraction averaged over ever larger cells: light that comes from
/// everywhere reaches the floor of a cavity less than a free face. It belongs to the bone and not to the view, so it
/// does not flicker between pictures.
class AmbientOcclusion {
 public:
  explicit AmbientOcclusion(const Occupancy& occupancy);

  void update(const Occupancy& occupancy, const std::vector<Vec3i>& bricks);

  /// 1 = nothing is occluded, 0 = all is. `point` in voxel index space, `normal` of length 1.
  [[nodiscard]] float accessibility(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) const;
  /// Bone that is farther than this from a point does not matter to it.
  [[nodiscard]] double reach_voxels() const;

 private:
  /// Cells of `cell_voxels`³ voxels, x fastest.
  struct Level {
    int cell_voxels;
    Vec3i dims;
    std::vector<float> fractions;
    [[nodiscard]] float& at(const Vec3i& cell);
    [[nodiscard]] float get(int x, int y, int z) const;
    [[nodiscard]] float sample(const Eigen::Vector3f& point) const;
    /// Between eight cells that all lie in the level: the lowest is `c`, and `t` the way to the next ones.
    [[nodiscard]] float inside(const Vec3i& c, const Eigen::Vector3f& t) const;
  };

  /// Where the i-th of the distances is sampled: in which cells, and how far from the point (voxels).
  struct Probe {
    const Level* level;
    float offset;
  };
  [[nodiscard]] Probe probe_at(std::size_t distance) const;

  void average_brick(const Occupancy& occupancy, const Vec3i& brick);
  void average_coarse();

  double voxel_mm_;
  std::vector<Level> levels_;
};

}  // namespace reamsim
