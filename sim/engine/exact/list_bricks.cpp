#include "sim/engine/exact/list_bricks.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace reamsim {

namespace embedded {
extern const char* const kernel_list_bricks;
}

// Host and device lay the structs out alike.
static_assert(sizeof(SubstepWindow) == 12);
static_assert(sizeof(VisitCounts) == 12);
static_assert(sizeof(CoarseGrid) == 20);

CoarseDistance make_coarse_distance(const Profile& profile, double voxel_mm, double slack_mm) {
  constexpr double kSuperbrickVoxels = 27.8;  // SUPERBRICK_RADIUS
  constexpr double kCellVoxels = 4, kMostCells = 1 << 14;
  const Aabb tool = profile.bounds();
  const double margin = (kSuperbrickVoxels + kVisitShiftVoxels + kCellVoxels) * voxel_mm + slack_mm;
  const double width = tool.max.x() + margin, height = tool.max.z() - tool.min.z() + 2 * margin;
  const double cell_mm = std::max(kCellVoxels * voxel_mm, std::sqrt(width * height / kMostCells));
  CoarseDistance out;
  out.grid = {static_cast<float>(tool.min.z() - margin), static_cast<float>(1 / cell_mm),
              // Rounding may put a point into the next cell.
              static_cast<float>(std::sqrt(0.5) * cell_mm + 1e-3), static_cast<rs_i32>(std::ceil(width / cell_mm)),
              static_cast<rs_i32>(std::ceil(height / cell_mm))};
  for (int z = 0; z < out.grid.count_z; ++z) {
    for (int r = 0; r < out.grid.count_r; ++r) {
      const Vec2 center((r + 0.5) * cell_mm, tool.min.z() - margin + (z + 0.5) * cell_mm);
      out.mm.push_back(static_cast<float>(profile.nearest(center).distance_mm));
    }
  }
  return out;
}

ListBricks::ListBricks(const cl::Device& device, const DeviceBricks& bone, const DeviceBatch& batch,
                       const Profile& profile, double slack_mm, std::size_t work_group)
    : device_(device),
      work_group_(work_group),
      slack_mm_(static_cast<float>(slack_mm)),
      grid_(device, 1, "the tool's distances"),
      listed_(device, std::max<std::size_t>(1, bone.layout.bricks), "the list of bricks in reach"),
      counts_(device, 1, "the counts of a visit"),
      kernel_(device.build("list_bricks.cl", embedded::kernel_list_bricks, ""), "list_bricks") {
  const CoarseDistance coarse = make_coarse_distance(profile, bone.grid.voxel_mm, slack_mm);
  grid_.write(device, &coarse.grid, 1);
  distances_ = {device, coarse.mm.size(), "the tool's distances"};
  distances_.write(device, coarse.mm.data(), coarse.mm.size());
  kernel_.set(Argument::args, batch.args());
  kernel_.set(Argument::coarse, grid_);
  kernel_.set(Argument::distances, distances_);
  kernel_.set(Argument::occupancy, bone.occupancy);
  kernel_.set(Argument::slot_of_brick, bone.slot_of_brick);
  kernel_.set(Argument::bricks, bone.dims);
  kernel_.set(Argument::listed, listed_);
  kernel_.set(Argument::counts, counts_);
}

std::size_t ListBricks::list(const VisitPlan& visit, VisitCounts counts) {
  counts_.write(device_, &counts, 1);
  if (visit.superbricks.empty()) return 0;
  const Vec3i first = visit.superbricks.first, size = visit.superbricks.size();
  kernel_.set(Argument::substep, static_cast<cl_uint>(visit.first));
  kernel_.set(Argument::first_super, cl_int4{{first.x(), first.y(), first.z(), 0}});
  kernel_.set(Argument::supers, cl_int4{{size.x(), size.y(), size.z(), 0}});
  kernel_.set(Argument::shift_mm, visit.shift_mm + slack_mm_);
  const auto items =
      static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()) * static_cast<std::size_t>(size.z());
  events_.push_back(kernel_.launch(device_, items, work_group_));
  counts_.read(device_, &counts, 1);
  return counts.listed;
}

double ListBricks::take_seconds() {
  const std::vector<double> seconds = cl::take_seconds(events_);
  return std::accumulate(seconds.begin(), seconds.end(), 0.0);
}

}  // namespace reamsim
