#include "sim/engine/common/voxel_box.h"

#include <algorithm>
#include <cmath>

namespace reamsim {

namespace {

/// Rounding allowance, voxels: more than the kernels' single precision loses, less than would cost time.
constexpr double kSlack = 0.05;

}  // namespace

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
    voi.first[i] = static_cast<int>(std::clamp(low, double(bone.first[i]), bone.last[i] + 1.0));
    voi.last[i] = static_cast<int>(std::clamp(high, bone.first[i] - 1.0, double(bone.last[i])));
  }
  return voi;
}

}  // namespace reamsim
