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

  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t vertex) const { return part_of(joined_, vertex); }
  /// For each neighbour the third corner of the triangle in which it follows the vertex.
  [[nodiscard]] std::span<const std::uint32_t> after(std::size_t vertex) const { return part_of(third_, vertex); }
  /// The part of `all`, which has a value for every neighbour of every vertex, that belongs to a vertex.
  template <typename T>
  [[nodiscard]] std::span<T> part_of(std::vector<T>& all, std::size_t vertex) const {
    return {all.data() + starts_[vertex], starts_[vertex + 1] - starts_[vertex]};
  }
  template <typename T>
  [[nodiscard]] std::span<const T> part_of(const std::vector<T>& all, std::size_t vertex) const {
    return {all.data() + starts_[vertex], starts_[vertex + 1] - starts_[vertex]};
  }
  /// How many values such a vector has.
  [[nodiscard]] std::size_t count() const { return joined_.size(); }

 private:
  std::vector<std::uint32_t> starts_;
  std::vector<std::uint32_t> joined_;
  std::vector<std::uint32_t> third_;
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

/// How much each neighbour counts in a mean that leaves alone what changes evenly along the surface, however uneven its
/// triangles are: mean value coordinates (Floater 2003, doi:10.1016/S0167-8396(03)00002-5), 1 on average. Equal weights
/// would take a value over from where the neighbours' middle happens to lie, and lines along it would zigzag.
std::vector<float> mean_value_weights(const Neighbours& neighbours, const std::vector<Eigen::Vector3f>& points);

/// A number per vertex becomes, `rounds` times, the mean over itself and its neighbours: `weights` per vertex times
/// mean_value_weights(). Where no weight is, it stays.
void smooth_values(const Neighbours& neighbours, const std::vector<float>& even, const std::vector<float>& weights,
                   std::vector<float>& values, int rounds);

}  // namespace reamsim
