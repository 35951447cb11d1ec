// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "tests/bench/reference/reference.h"

#include <algorithm>
#include <array>
#include <bit>

#include "sim/base/error.h"
#include "sim/engine/common/tables.h"
#include "tests/bench/reference/bone_memory.h"
#include "tests/bench/reference/frame.h"
#include "tests/bench/reference/workers.h"

namespace reamsim::reference {

namespace {

struct Passes {
  void (*detect)(Frame&);
  void (*cut)(Frame&);
};

Passes passes_for(Target target) {
#ifdef REAMSIM_REFERENCE_X86
  if (target == Target::avx512) return {avx512::detect, avx512::cut};
  if (target == Target::avx2) return {avx2::detect, avx2::cut};
#endif
  check_compiled(target);
  return {plain::detect, plain::cut};
}

}  // namespace

/// The memory that a Frame points into.
struct Reference::State {
  State(const BoneView& bone, const Tool& tool, const CuttingSettings& cutting, Target target, unsigned threads)
      : bone_memory(bone),
        shell(make_shell_cells(tool.shell, shell_cell_side(tool.shell.cell_mm / bone.voxmap.grid.voxel_mm))),
        outline(make_outline_table(tool.profile, bone.voxmap.grid.voxel_mm)),
        energy(make_energy_table(cutting, bone.voxmap.grid.voxel_mm)),
        passes(passes_for(target)),
        workers(threads) {
    listed.resize(bone_memory.count());
    touched_list.resize(bone_memory.count());
    // A block is removed only where a point touches it, and once.
    removed.resize(std::min(tool.shell.codes.size(), 8 * bone_memory.count()));
    point_frame();
  }

  void point_frame() {
    frame.runs = shell.runs.data();
    frame.run_count = static_cast<rs_u32>(shell.runs.size());
    frame.cells = shell.cells.data();
    frame.offsets = shell.offsets.data();
    frame.bone = bone_memory.arrays();
    frame.units = energy.units.data();
    frame.bits_of_byte = bits_of_bytes().data();
    frame.outline = view_of(outline);
    frame.listed = listed.data();
    frame.touched_list = touched_list.data();
    frame.removed = removed.data();
  }

  BoneMemory bone_memory;
  ShellCells shell;
  OutlineTable outline;
  EnergyTable energy;
  std::vector<rs_u32> listed, touched_list;
  std::vector<RemovedBlock> removed;
  Frame frame{};
  Passes passes;
  Workers workers;
};

Reference::Reference(const BoneView& bone, const Tool& tool, const CuttingSettings& cutting, Target target,
                     unsigned threads) {
  if (cutting.law != CuttingLaw::energy || cutting.erosion != ErosionMode::remove || cutting.size_effect) {
    throw RunError("the reference supports only law energy without size effect and erosion remove, not " +
                   name_of(cutting.law) + " and " + name_of(cutting.erosion));
  }
  state_ = std::make_unique<State>(bone, tool, cutting, target, threads);
}

Reference::~Reference() = default;

SubstepSums Reference::run(const SubstepArgs& args) {
  Frame& f = state_->frame;
  f.args = &args;
  f.touched_count = f.removed_count = f.next_run = f.next_touched = 0;
  f.sums = {};
  state_->workers.run([&] { state_->passes.detect(f); });
  if (f.touched_count > 0) state_->workers.run([&] { state_->passes.cut(f); });
  f.args = nullptr;
  return f.sums;
}

std::vector<RemovedBlock> Reference::removed() const {
  return {state_->removed.begin(), state_->removed.begin() + state_->frame.removed_count};
}

std::vector<std::int64_t> Reference::removed_voxels() const {
  std::vector<std::int64_t> out;
  for (const RemovedBlock& block : removed()) {
    for (rs_u64 rest = block.removed; rest != 0; rest &= rest - 1) {
      const auto place = static_cast<rs_i32>(block.detail << 6) + std::countr_zero(rest);
      out.push_back(voxel_index(state_->bone_memory, block.brick, place));
    }
  }
  std::sort(out.begin(), out.end());
  return out;
}

void Reference::restore() {
  for (const RemovedBlock& block : removed()) {
    Brick& brick = state_->bone_memory.brick_at(block.brick);
    brick.bone[2 * block.detail] |= static_cast<rs_u32>(block.removed);
    brick.bone[2 * block.detail + 1] |= static_cast<rs_u32>(block.removed >> 32);
    state_->bone_memory.occupy(state_->bone_memory.lattice().coord(block.brick));
  }
}

}  // namespace reamsim::reference
