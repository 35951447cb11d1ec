#include "render/report/page_data.h"

#include <algorithm>

#include "sim/base/error.h"

namespace reamsim {
namespace {

constexpr int kCarry_cells = 2;  // into the air

std::int64_t cells_of(const Vec3i& dims) {
  return std::int64_t{dims.x()} * dims.y() * dims.z();
}

std::size_t index_of(const Vec3i& dims, const Vec3i& cell) {
  return static_cast<std::size_t>(cell.x() + std::int64_t{dims.x()} * (cell.y() + std::int64_t{dims.y()} * cell.z()));
}

/// Voxels along a cell's edge, and how many cells there are then.
int voxels_per_cell(const Vec3i& voxels, std::int64_t most_cells, Vec3i& dims) {
  for (int n = 1;; ++n) {
    dims = (voxels.array() + n - 1) / n + 2 * kCarry_cells;
    if (cells_of(dims) <= most_cells || dims.maxCoeff() <= 1 + 2 * kCarry_cells) return n;
  }
}

/// Air cells beside bone get the mean of the bone that they touch.
void carry_on(const Vec3i& dims, std::vector<std::uint8_t>& grades) {
  const std::vector<std::uint8_t> before = grades;
  const std::array<Vec3i, 6> sides{Vec3i(-1, 0, 0), Vec3i(1, 0, 0),  Vec3i(0, -1, 0),
                                   Vec3i(0, 1, 0),  Vec3i(0, 0, -1), Vec3i(0, 0, 1)};
  for (int z = 0; z < dims.z(); ++z) {
    for (int y = 0; y < dims.y(); ++y) {
      for (int x = 0; x < dims.x(); ++x) {
        const Vec3i cell(x, y, z);
        if (before[index_of(dims, cell)] != 0) continue;
        int sum = 0, count = 0;
        for (const Vec3i& side : sides) {
          const Vec3i near = cell + side;
          if ((near.array() < 0).any() || (near.array() >= dims.array()).any()) continue;
          const int grade = before[index_of(dims, near)];
          sum += grade;
          count += grade != 0 ? 1 : 0;
        }
        if (count > 0) grades[index_of(dims, cell)] = static_cast<std::uint8_t>((sum + count / 2) / count);
      }
    }
  }
}

}  // namespace

DensityVolume density_volume(const Voxmap& voxmap, std::int64_t most_cells) {
  const VoxelBox bone = bone_extent(voxmap);
  if (bone.empty()) throw InputError({"reamed.vdb", 0, 0}, "density", "contains no bone", "the bone of a run");
  DensityVolume out;
  const int n = voxels_per_cell(bone.size(), most_cells, out.dims);
  out.cell_mm = n * voxmap.grid.voxel_mm;
  const Vec3i first = bone.first - Vec3i::Constant(n * kCarry_cells);
  out.origin_mm = voxmap.grid.origin_mm + voxmap.grid.voxel_mm * first.cast<double>();
  std::vector<std::uint32_t> sums(static_cast<std::size_t>(cells_of(out.dims)));
  std::vector<std::uint32_t> counts(sums.size());
  voxmap.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick& grades) {
    for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
      const std::uint8_t grade = grades[static_cast<std::size_t>(offset)];
      if (grade == 0) continue;
      const std::size_t cell = index_of(out.dims, (BrickLattice::voxel_at(coord, offset) - first) / n);
      sums[cell] += grade;
      ++counts[cell];
    }
  });
  out.grades.resize(sums.size());
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (counts[i] > 0) out.grades[i] = static_cast<std::uint8_t>((sums[i] + counts[i] / 2) / counts[i]);
  }
  for (int round = 0; round < kCarry_cells; ++round) carry_on(out.dims, out.grades);
  return out;
}

}  // namespace reamsim
