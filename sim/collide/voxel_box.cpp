#include "sim/collide/voxel_box.h"

#include <algorithm>
#include <cmath>

namespace reamsim {

namespace {

/// Rounding allowance, voxels: more than the kernels' single precision loses, less than would cost time.
constexpr double kSlack = 0.05;

}  // namespace

VoxelBox bone_voxels(const Voxmap& voxmap) {
  VoxelBox box{voxmap.grid.dims, Vec3i::Constant(-1)};
  for (std::int64_t e = 0; e < voxmap.grid.size(); ++e) {
    if (voxmap.grade[static_cast<std::size_t>(e)] == 0) continue;
    const Vec3i voxel = voxmap.grid.coord(e);
    box.min = box.min.cwiseMin(voxel);
    box.max = box.max.cwiseMax(voxel);
  }
  return box;
}

VoxelBox voxel_voi(const SubstepArgs& args, const Aabb& tool_box, const VoxelBox& bone) {
  // Row-major read column by column: the transpose, which but for the voxel's size is the inverse.
  const Eigen::Map<const Mat3> transposed(args.tool_from_voxel);
  const Mat3 voxel_from_tool = transposed / transposed.row(0).squaredNorm();
  const Vec3 center = voxel_from_tool * (tool_box.center() - Eigen::Map<const Vec3>(args.tool_origin));
  const Vec3 half = voxel_from_tool.cwiseAbs() * tool_box.half() + Vec3::Constant(kSlack);
  VoxelBox voi;
  for (int i = 0; i < 3; ++i) {
    // Clamped before the conversion, because a far tool overflows an int.
    const double low = std::ceil(center[i] - half[i]), high = std::floor(center[i] + half[i]);
    voi.min[i] = static_cast<int>(std::clamp(low, double(bone.min[i]), bone.max[i] + 1.0));
    voi.max[i] = static_cast<int>(std::clamp(high, bone.min[i] - 1.0, double(bone.max[i])));
  }
  return voi;
}

}  // namespace reamsim
