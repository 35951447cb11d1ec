#include "sim/bench/published.h"

#include <bit>

#include "sim/base/error.h"
#include "sim/bench/poses.h"

namespace reamsim::bench {

// Host and device lay the struct out alike.
static_assert(sizeof(PublishedFrame) == 8 * 4 + 4 * 16 + 4 * 8);

PublishedFrame published_frame(const Substep& substep, const std::optional<Aabb>& voi, const Tool& tool,
                               const VoxelGrid& grid) {
  if (grid.dims != Vec3i::Constant(grid.dims.x())) throw InputError("the published methods need a cubic lattice");
  const PointShell& shell = tool.shell;
  // The VOI in cells is the engines'.
  const SubstepArgs args =
      voi ? make_args(substep, *voi, shell, grid, bench_cutting(), false) : args_without_voi(substep, tool, grid);
  const Rigid bone_from_tool = substep.pose.bone_from_tool();
  const Vec3 first_cell = shell.origin_mm + Vec3::Constant(0.5 * shell.cell_mm);
  const Vec3 origin = (bone_from_tool * first_cell - grid.origin_mm) / grid.voxel_mm;
  const Mat3 step = bone_from_tool.linear() * (shell.cell_mm / grid.voxel_mm);
  const Vec3 center = (Vec3(0, 0, kReamerMm) - first_cell) / shell.cell_mm;
  PublishedFrame frame{};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) frame.voxel_from_cell[3 * i + j] = static_cast<float>(step(i, j));
    frame.voxel_origin[i] = static_cast<float>(origin[i]);
    frame.cap_center[i] = static_cast<float>(center[i]);
    frame.voi_min[i] = args.voi_min[i];
    frame.voi_max[i] = args.voi_max[i];
  }
  frame.side = grid.dims.x();
  return frame;
}

std::vector<cl_uint> descent_steps(int side) {
  if (side < 1 || !std::has_single_bit(static_cast<unsigned>(side))) {
    throw InputError("the octree's cube has " + std::to_string(side) + " voxels an edge; expected a power of two");
  }
  std::vector<cl_uint> steps;
  const auto n = static_cast<cl_uint>(side);
  for (cl_uint half = n / 2; half > 0; half /= 2) {
    for (cl_uint octant = 0; octant < 8; ++octant) {
      const cl_uint x = octant & 1, y = octant >> 1 & 1, z = octant >> 2;
      steps.push_back(half * (x + n * (y + n * z)));
    }
  }
  if (steps.empty()) steps.assign(8, 0);
  return steps;
}

}  // namespace reamsim::bench
