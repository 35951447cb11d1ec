#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "sim/mesh/triangle_mesh.h"
#include "sim/tool/profile.h"

namespace reamsim {

/// The signed distance to a closed mesh next to its surface, negative inside, in the mesh's frame: samples on a cubic
/// lattice, trilinear in between. Kept in bricks of 8×8×8 cells; a brick holds the samples at all corners of its
/// cells.
struct DistanceGrid {
  static constexpr int kSide = 8;         ///< cells of a brick along an axis
  static constexpr int kRow = kSide + 1;  ///< samples
  static constexpr std::size_t kSamples = kRow * kRow * kRow;
  static constexpr std::uint32_t kOutside = 0, kInside = 1;  ///< slots of bricks far from the surface

  Vec3 origin_mm = Vec3::Zero();  ///< sample (0,0,0)
  double spacing_mm = 0;
  double band_mm = 0;   ///< distances are cut to this
  double slack_mm = 0;  ///< no point is further outside the envelope than from the surface as sampled, plus this
  Vec3i bricks = Vec3i::Zero();
  std::vector<std::uint32_t> slot_of_brick;  ///< x before y before z
  std::vector<float> samples;                ///< mm, slot by slot, x before y before z
  double volume_mm3 = 0;                     ///< inside, as the trilinear distance has it
  double mesh_mm3 = 0;                       ///< inside the mesh

  [[nodiscard]] double volume_error() const { return volume_mm3 / mesh_mm3 - 1; }
  [[nodiscard]] std::size_t stored_bricks() const { return samples.size() / kSamples; }
  [[nodiscard]] std::size_t bytes() const {
    return samples.size() * sizeof(float) + slot_of_brick.size() * sizeof(std::uint32_t);
  }
  /// The sample at the lowest corner of cell `cell`, which lies on the lattice.
  [[nodiscard]] const float* lowest_corner(const Vec3i& cell) const;
};

/// Spacing of a tool's grid, voxels.
inline constexpr double kGridSpacingVoxels = 0.5;

/// Samples the distance to the mesh (closed, facing outwards; T, mm) for clipping voxels of `voxel_mm`: every
/// `kGridSpacingVoxels`, as far from the surface as a voxel that it meets within a window of substeps can be.
/// `envelope`: what the mesh sweeps. Throws InputError where OpenVDB finds no distance.
DistanceGrid make_distance_grid(const TriangleMesh& mesh, const Profile& envelope, double voxel_mm);

/// Memory that make_distance_grid() takes at most while it works, bytes; of this `kept_bytes` at most is what the grid
/// takes afterwards.
struct DistanceGridPlan {
  double working_bytes = 0;
  double kept_bytes = 0;
};
DistanceGridPlan plan_distance_grid(const TriangleMesh& mesh, double voxel_mm);

/// Throws InputError that says which voxels would fit where `need` bytes are more than `have`. `what` names the memory.
void require_room_for_grid(double need_bytes, double have_bytes, double voxel_mm, const std::string& what);

}  // namespace reamsim
