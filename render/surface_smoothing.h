#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

namespace reamsim {

/// Who is joined to whom by an edge of a closed triangle mesh.
class Neighbours {
 public:
  Neighbours(std::size_t vertices, std::span<const std::uint32_t> indices);

  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t vertex) const {
    return {joined_.data() + starts_[vertex], starts_[vertex + 1] - starts_[vertex]};
  }

 private:
  std::vector<std::uint32_t> starts_;
  std::vector<std::uint32_t> joined_;
};

/// Evens out what voxel steps leave in the shading: every normal becomes, `rounds` times, the mean of itself and those
/// neighbours that do not bend away by more than a crease, so that true edges stay sharp.
void smooth_normals(const Neighbours& neighbours, std::vector<Eigen::Vector3f>& normals, int rounds);

/// The same for a number per vertex, without creases.
void smooth_values(const Neighbours& neighbours, std::vector<float>& values, int rounds);

}  // namespace reamsim
