// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "tests/bench/reference/exact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sim/base/error.h"
#include "sim/base/stopwatch.h"
#include "sim/engine/common/tables.h"
#include "sim/engine/exact/brick_batch_plan.h"
#include "tests/bench/reference/bone_memory.h"
#include "tests/bench/reference/exact_visit.h"
#include "tests/bench/reference/workers.h"

namespace reamsim::reference {

namespace {

constexpr std::size_t kBatchSubsteps = 4096;

struct ExactPasses {
  void (*list)(ExactVisit&);
  void (*cut)(ExactVisit&);
};

ExactPasses exact_passes_for(Target target) {
#ifdef REAMSIM_REFERENCE_X86
  if (target == Target::avx512) return {avx512::list_bricks, avx512::cut_exact};
  if (target == Target::avx2) return {avx2::list_bricks, avx2::cut_exact};
#endif
  check_compiled(target);
  return {plain::list_bricks, plain::cut_exact};
}

void check_supported(const BoneView& bone, const Tool& tool, const CuttingSettings& cutting) {
  if (cutting.law != CuttingLaw::energy || cutting.erosion != ErosionMode::exact || cutting.edge_force) {
    throw RunError("the reference of exact supports only law energy without edge force and erosion exact, not " +
                   name_of(cutting.law) + " and " + name_of(cutting.erosion));
  }
  if (tool.teeth) throw RunError("the reference of exact supports no resolved cutting edges");
  if (bone.fill_before.stored_bricks() > 0) throw RunError("the reference of exact supports only bone of whole voxels");
}

/// Memory whose pages the system provides when they are first written.
template <class T>
class RoomFor {
 public:
  /// Room for `count` elements; keeps the first `used`. Grows by half, so that growing memory is copied seldom.
  T* reserve(std::size_t count, std::size_t used) {
    if (count > count_) {
      count_ = count + count / 2;
      auto grown = std::make_unique_for_overwrite<T[]>(count_);
      std::copy_n(memory_.get(), used, grown.get());
      memory_ = std::move(grown);
    }
    return memory_.get();
  }
  [[nodiscard]] const T* get() const { return memory_.get(); }
  [[nodiscard]] std::size_t bytes() const { return sizeof(T) * count_; }

 private:
  std::unique_ptr<T[]> memory_;
  std::size_t count_ = 0;
};

}  // namespace

/// The memory that an ExactVisit points into.
struct ExactReference::State {
  State(const BoneView& bone, const Tool& tool, const CuttingSettings& cutting, Target instructions, unsigned threads)
      : target(instructions),
        memory(bone),
        extent(bone_extent(bone.voxmap)),
        outline(make_outline_table(tool.profile, bone.voxmap.grid.voxel_mm)),
        tool_box(tool.clip_bounds().expanded(outline.bulge_mm)),
        slack_mm(static_cast<float>(tool.clip_slack_mm() + outline.bulge_mm)),
        distances(brick_distances(tool.profile, bone.voxmap.grid.voxel_mm, tool.clip_slack_mm() + outline.bulge_mm)),
        coarse(coarse_grid(distances)),
        passes(exact_passes_for(target)),
        workers(threads) {
    const EnergyTable table = make_energy_table(cutting, bone.voxmap.grid.voxel_mm);
    std::transform(table.energy_mj.begin(), table.energy_mj.end(), energy.begin(),
                   [](double mj) { return static_cast<float>(mj); });
    listed.resize(memory.count());
    page_of_slot.assign(memory.count(), -1);
  }

  /// Lists and cuts the bricks in reach in as many substeps from `first` on as a visit can have. Returns the slot after
  /// them.
  int run_visit(int first, Batch& batch) {
    const BrickBatchPlan plan = plan_brick_batch(args, motions, first, RS_VISIT_SUBSTEPS, tool_box, extent);
    if (plan.superbricks.empty()) return plan.end;
    ExactVisit visit = make_visit(plan, batch.sums.data() + first);
    const Stopwatch watch;
    workers.run([&] { passes.list(visit); });
    const double list_s = watch.seconds();
    if (visit.listed_count > 0) {
      // In the order of the lattice, so that neighbours follow each other whichever thread listed them.
      std::sort(listed.begin(), listed.begin() + visit.listed_count);
      visit.fills = fills.reserve((pages + visit.listed_count) * RS_BRICK_VOXELS, pages * RS_BRICK_VOXELS);
      visit.removed = removed_voxels.reserve(visit.listed_count * std::size_t{RS_BRICK_VOXELS}, 0);
      workers.run([&] { passes.cut(visit); });
    }
    pages = visit.page_count;
    append_removed_voxels(visit);
    const double substeps = plan.end - plan.first;
    const StageTimes mean{list_s / substeps, (watch.seconds() - list_s) / substeps};
    std::fill(batch.times.begin() + plan.first, batch.times.begin() + plan.end, mean);
    return plan.end;
  }

  ExactVisit make_visit(const BrickBatchPlan& plan, SubstepSums* sums) {
    const auto begin = static_cast<rs_u32>(plan.first);
    windows = plan.windows;
    visit_motions = plan.motions;
    for (SubstepWindow& window : windows) {
      window.first -= begin;
      window.end -= begin;
      for (rs_u32 s = window.first; s < window.end && window.motion >= 0; ++s) {
        times[s] = rs_window_time(&visit_motions[static_cast<std::size_t>(window.motion)], args[begin + s].frame);
      }
    }
    ExactVisit visit{};
    visit.args = args.data() + begin;
    visit.windows = windows.data();
    visit.window_count = static_cast<rs_u32>(windows.size());
    visit.motions = visit_motions.data();
    visit.times = times.data();
    visit.sums = sums;
    for (int i = 0; i < 3; ++i) {
      visit.first_super[i] = plan.superbricks.first[i];
      visit.supers[i] = plan.superbricks.size()[i];
    }
    visit.shift_mm = plan.shift_mm + slack_mm;
    visit.coarse = &coarse;
    visit.distances = distances.mm.data();
    visit.bone = memory.arrays();
    visit.page_of_slot = page_of_slot.data();
    visit.energy = energy.data();
    visit.bits_of_byte = bits_of_bytes().data();
    visit.outline = view_of(outline);
    visit.listed = listed.data();
    visit.page_count = static_cast<rs_u32>(pages);
    return visit;
  }

  void append_removed_voxels(const ExactVisit& visit) {
    for (rs_u32 i = 0; i < visit.removed_count; ++i) {
      const RemovedVoxel& voxel = visit.removed[i];
      removed.emplace_back(voxel_index(memory, voxel.brick, voxel.place), visit.args[voxel.slot].frame);
    }
  }

  Target target;
  BoneMemory memory;
  VoxelBox extent;
  OutlineTable outline;
  Aabb tool_box;
  float slack_mm;
  DistanceTable distances;
  CoarseGrid coarse;
  std::array<float, 256> energy{};
  std::vector<SubstepArgs> args;
  MotionsOfSlots motions;
  std::vector<SubstepWindow> windows;       // of the current visit
  std::vector<MotionWindow> visit_motions;  // of these
  std::array<float, RS_VISIT_SUBSTEPS> times{};
  std::vector<rs_u32> listed;
  std::vector<rs_i32> page_of_slot;
  std::size_t pages = 0;
  RoomFor<rs_u16> fills;
  RoomFor<RemovedVoxel> removed_voxels;
  RemovedFrames removed;
  ExactPasses passes;
  Workers workers;
};

ExactReference::ExactReference(const BoneView& bone, const Tool& tool, const CuttingSettings& cutting, Target target,
                               unsigned threads) {
  check_supported(bone, tool, cutting);
  state_ = std::make_unique<State>(bone, tool, cutting, target, threads);
}

ExactReference::~ExactReference() = default;

void ExactReference::enqueue(const SubstepArgs& args, std::shared_ptr<const MotionWindow> window) {
  state_->args.push_back(args);
  state_->motions.push_back(std::move(window));
}

bool ExactReference::full() const {
  return state_->args.size() >= kBatchSubsteps;
}

Batch ExactReference::collect() {
  state_->removed.clear();
  Batch out{std::vector<SubstepSums>(state_->args.size()), std::vector<StageTimes>(state_->args.size())};
  for (int first = 0; first < static_cast<int>(state_->args.size());) first = state_->run_visit(first, out);
  state_->args.clear();
  state_->motions.clear();
  return out;
}

RemovedFrames ExactReference::take_removed() {
  return std::exchange(state_->removed, {});
}

void ExactReference::read_fill(const Voxmap& /*voxmap*/, FillBricks& fill) {
  for (std::size_t slot = 0; slot < state_->page_of_slot.size(); ++slot) {
    if (state_->page_of_slot[slot] < 0) continue;
    const rs_u16* page =
        state_->fills.get() + static_cast<std::ptrdiff_t>(RS_BRICK_VOXELS) * state_->page_of_slot[slot];
    FillBricks::Brick brick{};
    for (int offset = 0; offset < FillBricks::kVoxels; ++offset) {
      const Vec3i voxel = BrickLattice::voxel_at(Vec3i::Zero(), offset);
      brick[static_cast<std::size_t>(offset)] = page[rs_brick_offset(voxel.x(), voxel.y(), voxel.z())];
    }
    fill.put(state_->memory.lattice().coord(state_->memory.lattice_index(slot)), brick);
  }
}

void ExactReference::restore(const BoneView& bone) {
  state_->memory.restore(bone.voxmap);
  state_->page_of_slot.assign(state_->memory.count(), -1);
  state_->pages = 0;
}

std::string ExactReference::device() const {
  return name_of(state_->target);
}

std::size_t ExactReference::device_bytes() const {
  return structure_bytes().voxmap + state_->removed_voxels.bytes() + sizeof(rs_u32) * state_->listed.size();
}

StructureBytes ExactReference::structure_bytes() const {
  return {state_->memory.bytes() + sizeof(rs_i32) * state_->page_of_slot.size() + state_->fills.bytes(), 0};
}

}  // namespace reamsim::reference
