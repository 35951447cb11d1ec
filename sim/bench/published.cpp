// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bench/published.h"

#include <bit>
#include <utility>

#include "sim/base/error.h"
#include "sim/bench/poses.h"

namespace reamsim::bench {

// The layout is the same on host and device.
static_assert(sizeof(PublishedFrame) == 8 * 4 + 4 * 16 + 4 * 8);

PublishedFrame published_frame(const Substep& substep, const std::optional<Aabb>& voi, const Tool& tool,
                               const VoxelGrid& grid) {
  if (grid.dims != Vec3i::Constant(grid.dims.x())) throw InputError("the published methods need a cubic lattice");
  const PointShell& shell = tool.shell;
  // The VOI in cells is that of the engines.
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

PublishedProgram::PublishedProgram(const std::string& engine, const cl::DeviceInfo& info, const BenchSetup& setup,
                                   const char* source, std::size_t record_words)
    : setup_(setup),
      device_(info),
      program_(device_.build("published_" + engine + ".cl", source)),
      points_(setup.tool->shell.codes.size()),
      frame_(device_, 1, "the frame"),
      label_{engine, "published"},
      touched_kernel_(program_, "published_touched"),
      restore_kernel_(program_, "published_restore"),
      touched_(device_, record_words * points_, "the touched voxels"),
      touched_count_(device_, 1, "their number") {}

void PublishedProgram::prepare(const Substep& frame) {
  const PublishedFrame args = published_frame(frame, std::nullopt, *setup_.tool, setup_.voxmap->grid);
  frame_.write(device_, &args, 1);
  touched_count_.clear(device_, 1);
  const cl::Event done = touched_kernel_.launch(device_, points_, kPublishedGroup);
  touched_count_.read(device_, &recorded_, 1);
  prepared_ = true;
}

BatchSample PublishedProgram::run(std::span<const Substep> frames, bool use_voi) {
  BatchSample sample;
  for (const Substep& frame : frames) run_one(frame, use_voi, sample);
  if (!std::exchange(prepared_, false)) changed_ = true;
  return sample;
}

void PublishedProgram::restore() {
  if (changed_) {
    restore_all();
  } else if (recorded_ > 0) {
    restore_kernel_.set(1, recorded_);
    const cl::Event done = restore_kernel_.launch(device_, recorded_, kPublishedGroup);
  }
  device_.finish();
  changed_ = prepared_ = false;
  recorded_ = 0;
}

}  // namespace reamsim::bench
