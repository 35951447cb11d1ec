// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/exact/list_bricks.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace reamsim {

namespace embedded {
extern const char* const kernel_list_bricks;
}

// The structs have the same layout on host and device.
static_assert(sizeof(SubstepWindow) == 16);
static_assert(sizeof(VisitCounts) == 16);
static_assert(sizeof(CoarseGrid) == 20);

DistanceTable brick_distances(const Profile& profile, double voxel_mm, double slack_mm) {
  constexpr double kCellVoxels = 4, kMaxCells = 1 << 14;
  const Aabb tool = profile.bounds();
  const double margin = (double{RS_SUPERBRICK_RADIUS} + kVisitShiftVoxels + kCellVoxels) * voxel_mm + slack_mm;
  const double width = tool.max.x() + margin, height = tool.max.z() - tool.min.z() + 2 * margin;
  const double cell_mm = std::max(kCellVoxels * voxel_mm, std::sqrt(width * height / kMaxCells));
  return make_distance_table(profile, Vec2(0, tool.min.z() - margin) + Vec2::Constant(0.5 * cell_mm), cell_mm,
                             static_cast<int>(std::ceil(width / cell_mm)),
                             static_cast<int>(std::ceil(height / cell_mm)));
}

CoarseGrid coarse_grid(const DistanceTable& table) {
  constexpr double kRounding_mm = 1e-3;  // may move a point into the next cell
  return {static_cast<float>(table.first.y() - 0.5 * table.pitch_mm), static_cast<float>(1 / table.pitch_mm),
          static_cast<float>(std::sqrt(0.5) * table.pitch_mm + kRounding_mm), table.count_r, table.count_z};
}

namespace {

/// Number of the first argument that all visits share; those before it are set by list().
constexpr cl_uint kAfterVisitArguments = 4;

}  // namespace

ListBricks::ListBricks(const cl::Device& device, const DeviceBricks& bone, const DeviceBatch& batch,
                       const Profile& profile, double slack_mm, std::size_t work_group)
    : device_(device),
      slack_mm_(static_cast<float>(slack_mm)),
      listed_(device, std::max<std::size_t>(1, bone.layout.bricks), "the list of bricks in reach"),
      counts_(device, 1, "the counts of a visit"),
      kernel_(device, device.build("list_bricks.cl", embedded::kernel_list_bricks), "list_bricks", work_group) {
  const DistanceTable table = brick_distances(profile, bone.grid.voxel_mm, slack_mm);
  grid_ = cl::upload(device, std::array{coarse_grid(table)}, "the tool's distances");
  distances_ = cl::upload(device, table.mm, "the tool's distances");
  kernel_.set_from(kAfterVisitArguments, batch.args(), grid_, distances_, bone.occupancy, bone.slot_of_brick, bone.dims,
                   listed_, counts_);
}

std::size_t ListBricks::list(const BrickBatchPlan& visit, VisitCounts counts) {
  if (visit.superbricks.empty()) return 0;
  counts_.write(device_, &counts, 1, 0, false);
  const Vec3i first = visit.superbricks.first, size = visit.superbricks.size();
  kernel_.set_from(cl::SlotKernel::kAfterSlot, cl_int4{{first.x(), first.y(), first.z(), 0}},
                   cl_int4{{size.x(), size.y(), size.z(), 0}}, visit.shift_mm + slack_mm_);
  kernel_.run(visit.first, static_cast<std::size_t>(size.cast<std::int64_t>().prod()));
  counts_.read(device_, &counts, 1);
  return counts.listed;
}

}  // namespace reamsim
