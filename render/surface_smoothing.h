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

/// Moves points until the surface fits its (smoothed) normals: each goes, `rounds` times, to the mean of where
/// its neighbours want it, perpendicular to the normals between (after Sun, Rosin, Martin and Langbein 2007,
/// doi:10.1109/TVCG.2007.1065, §5, with vertex normals), but no farther than `most` from where it was. Takes the
/// voxels' terraces off outlines too.
void fit_to_normals(const Neighbours& neighbours, const std::vector<Eigen::Vector3f>& normals,
                    std::vector<Eigen::Vector3f>& points, int rounds, float most);

/// A number per vertex becomes, `rounds` times, the mean over itself and its neighbours, weighted; where no weight is,
/// it stays.
void smooth_values(const Neighbours& neighbours, const std::vector<float>& weights, std::vector<float>& values,
                   int rounds);

}  // namespace reamsim
