#include "sim/collide/voxel_box.h"

#include <algorithm>
#include <cmath>

namespace reamsim {

namespace {

/// Rounding allowance, voxels: far more than doubles lose, far less than would cost time.
constexpr double kSlack = 1e-6;

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
  const Mat3 bone_from_tool = Eigen::Map<const Mat3>(args.tool_from_bone);  // row-major read column by column
  const Vec3 corner(args.lattice_origin[0], args.lattice_origin[1], args.lattice_origin[2]);
  const Vec3 center = (bone_from_tool * tool_box.center() - corner) / args.voxel_mm;
  const Vec3 half = bone_from_tool.cwiseAbs() * tool_box.half() / args.voxel_mm + Vec3::Constant(kSlack);
  VoxelBox voi;
  for (int i = 0; i < 3; ++i) {
    // Voxel v has its centre at v + 1/2. Clamped before the conversion, because a far tool overflows an int.
    const double low = std::ceil(center[i] - half[i] - 0.5), high = std::floor(center[i] + half[i] - 0.5);
    voi.min[i] = static_cast<int>(std::clamp(low, double(bone.min[i]), bone.max[i] + 1.0));
    voi.max[i] = static_cast<int>(std::clamp(high, bone.min[i] - 1.0, double(bone.max[i])));
  }
  return voi;
}

}  // namespace reamsim
