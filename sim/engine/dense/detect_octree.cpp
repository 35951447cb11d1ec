#include "sim/engine/dense/detect_octree.h"

#include <algorithm>

#include "sim/tool/morton.h"

namespace reamsim {

namespace embedded {
extern const char* const kernel_detect_octree;
}

namespace {

std::string build_options(bool per_point, std::size_t work_group) {
  return per_point ? "-DREAMSIM_GROUP_SIZE=" + std::to_string(work_group) : "";
}

/// Cell numbers as floats, which hold them exactly up to 2^24.
std::vector<cl_float> cell_numbers(const PointShell& shell) {
  std::vector<cl_float> out;
  out.reserve(3 * shell.codes.size());
  for (const std::uint64_t code : shell.codes) {
    const Vec3i cell = morton_decode(code);
    for (int axis = 0; axis < 3; ++axis) out.push_back(static_cast<cl_float>(cell[axis]));
  }
  return out;
}

}  // namespace

int octree_levels(const VoxelGrid& grid) {
  int levels = 0;
  while ((std::int64_t{1} << levels) < grid.dims.maxCoeff()) ++levels;
  return levels;
}

std::vector<cl_uint4> octree_children(const VoxelGrid& grid) {
  std::vector<cl_uint4> children;
  const int levels = octree_levels(grid);
  for (int level = 0; level < levels; ++level) {
    const std::int64_t half_side = std::int64_t{1} << (levels - 1 - level);
    for (int octant = 0; octant < 8; ++octant) {
      const std::int64_t x = (octant & 1) * half_side, y = (octant >> 1 & 1) * half_side, z = (octant >> 2) * half_side;
      // Octants wholly outside the lattice get a step that means nothing; no point descends into them.
      const std::int64_t step = x + grid.dims.x() * (y + grid.dims.y() * z);
      children.push_back(
          {{static_cast<cl_uint>(x), static_cast<cl_uint>(y), static_cast<cl_uint>(z), static_cast<cl_uint>(step)}});
    }
  }
  return children;
}

DetectOctree::DetectOctree(const cl::Device& device, const DenseState& state, const DeviceBatch& batch,
                           const PointShell& shell, const VoxelGrid& grid, bool per_point, std::size_t work_group)
    : count_(shell.codes.size()),
      points_(device, std::max<std::size_t>(1, 3 * count_), "the point shell"),
      children_(device, std::max(1, 8 * octree_levels(grid)), "the look-up tables"),
      kernel_(device,
              device.build("detect_octree.cl", embedded::kernel_detect_octree,
                           build_options(per_point, std::min(work_group, kMostPerGroup))),
              "detect_octree", Argument::substep, std::min(work_group, kMostPerGroup)) {
  const auto points = cell_numbers(shell);
  if (!points.empty()) points_.write(device, points.data(), points.size());
  const auto children = octree_children(grid);
  if (!children.empty()) children_.write(device, children.data(), children.size());
  kernel_.set(Argument::points, points_);
  kernel_.set(Argument::point_count, static_cast<cl_uint>(count_));
  kernel_.set(Argument::args, batch.args());
  kernel_.set(Argument::hu, state.hu);
  kernel_.set(Argument::hu_of_air, static_cast<cl_float>(state.scale.of_air));
  kernel_.set(Argument::flags, state.claims);
  kernel_.set(Argument::contacts, state.contacts);
  kernel_.set(Argument::contact_count, batch.contact_count());
  kernel_.set(Argument::sums, batch.sums());
  state.profile.set(kernel_, Argument::edges);
  kernel_.set(Argument::children, children_);
  kernel_.set(Argument::levels, static_cast<cl_int>(octree_levels(grid)));
}

void DetectOctree::enqueue(int slot) {
  kernel_.run(slot, count_);
}

}  // namespace reamsim
