#include "tests/bench/reference/reference.h"

#include <algorithm>
#include <array>
#include <bit>

#include "sim/base/error.h"
#include "sim/engine/bricked/shell_cells.h"
#include "sim/engine/common/energy_table.h"
#include "sim/engine/common/outline_table.h"
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
  if (target != Target::plain) throw RunError(std::string(name_of(target)) + " is not compiled here");
  return {plain::detect, plain::cut};
}

Brick brick_of(const GradeBricks::Brick& grades) {
  Brick out{};
  for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
    const Vec3i voxel = BrickLattice::voxel_at(Vec3i::Zero(), offset);
    const auto place = static_cast<std::size_t>(rs_brick_offset(voxel.x(), voxel.y(), voxel.z()));
    out.grade[place] = grades[static_cast<std::size_t>(offset)];
    if (out.grade[place] != 0) out.bone[place >> 5] |= 1U << (place & 31U);
  }
  return out;
}

/// Per byte the numbers of its bits, a byte each, lowest first; then zeros.
std::vector<rs_u64> bits_of_byte() {
  std::vector<rs_u64> out(256);
  for (unsigned byte = 0; byte < 256; ++byte) {
    int at = 0;
    for (unsigned bit = 0; bit < 8; ++bit) {
      if ((byte >> bit & 1U) != 0) out[byte] |= rs_u64{bit} << (8 * at++);
    }
  }
  return out;
}

}  // namespace

const char* name_of(Target target) {
  return target == Target::avx512 ? "AVX-512" : target == Target::avx2 ? "AVX2" : "plain";
}

std::vector<Target> usable_targets() {
  std::vector<Target> out{Target::plain};
#ifdef REAMSIM_REFERENCE_X86
  const bool avx2 = __builtin_cpu_supports("avx2") != 0;
  const bool avx512 = __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512dq") != 0 &&
                      __builtin_cpu_supports("avx512bw") != 0 && __builtin_cpu_supports("avx512vl") != 0;
  if (avx2) out.push_back(Target::avx2);
  if (avx2 && avx512) out.push_back(Target::avx512);
#endif
  return out;
}

/// The memory that a Frame points into.
struct Reference::State {
  State(const BoneView& bone, const Tool& tool, const CuttingSettings& cutting, Target target, unsigned threads)
      : grid(bone.voxmap.grid),
        lattice(BrickLattice::over(grid.dims)),
        shell(make_shell_cells(tool.shell, shell_cell_side(tool.shell.cell_mm / grid.voxel_mm))),
        outline(make_outline_table(tool.profile, grid.voxel_mm)),
        energy(make_energy_table(cutting, grid.voxel_mm)),
        bits(bits_of_byte()),
        passes(passes_for(target)),
        workers(threads) {
    std::transform(energy.energy_mj.begin(), energy.energy_mj.end(), units.begin(), rs_energy_units);
    take_bone(bone.voxmap);
    listed.resize(bricks.size());
    touched_list.resize(bricks.size());
    // A block cannot go without a point that touches it, nor twice.
    removed.resize(std::min(tool.shell.codes.size(), 8 * bricks.size()));
    point_frame();
  }

  void take_bone(const Voxmap& voxmap) {
    slot_of_brick.assign(lattice.count(), -1);
    const Vec3i superbricks = (lattice.dims.array() + 3) / 4;
    occupancy.resize(2 * static_cast<std::size_t>(superbricks.cast<std::int64_t>().prod()));
    voxmap.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick& grades) {
      const std::size_t index = lattice.index(coord);
      slot_of_brick[index] = static_cast<rs_i32>(bricks.size());
      lattice_of_slot.push_back(static_cast<rs_u32>(index));
      bricks.push_back(brick_of(grades));
      occupy(coord);
    });
  }

  void occupy(const Vec3i& brick) {
    const Vec3i n = (lattice.dims.array() + 3) / 4, s = brick / 4;
    const auto word = 2 * static_cast<std::size_t>(s.x() + n.x() * (s.y() + n.y() * s.z()));
    const auto bit = static_cast<unsigned>((brick.x() & 3) | (brick.y() & 3) << 2 | (brick.z() & 3) << 4);
    occupancy[word + (bit >> 5)] |= 1U << (bit & 31U);
  }

  void point_frame() {
    frame.runs = shell.runs.data();
    frame.run_count = static_cast<rs_u32>(shell.runs.size());
    frame.cells = shell.cells.data();
    frame.offsets = shell.offsets.data();
    frame.bricks = bricks.data();
    frame.slot_of_brick = slot_of_brick.data();
    frame.lattice_of_slot = lattice_of_slot.data();
    frame.occupancy = occupancy.data();
    for (int i = 0; i < 3; ++i) frame.brick_dims[i] = lattice.dims[i];
    frame.energy = energy.energy_mj.data();
    frame.units = units.data();
    frame.bits_of_byte = bits.data();
    frame.outline = view_of(outline);
    frame.listed = listed.data();
    frame.touched_list = touched_list.data();
    frame.removed = removed.data();
  }

  VoxelGrid grid;
  BrickLattice lattice;
  ShellCells shell;
  OutlineTable outline;
  EnergyTable energy;
  std::array<rs_i64, 256> units{};
  std::vector<rs_u64> bits;
  std::vector<Brick> bricks;
  std::vector<rs_i32> slot_of_brick;
  std::vector<rs_u32> lattice_of_slot, occupancy, listed, touched_list;
  std::vector<RemovedBlock> removed;
  Frame frame{};
  Passes passes;
  Workers workers;
};

Reference::Reference(const BoneView& bone, const Tool& tool, const CuttingSettings& cutting, Target target,
                     unsigned threads) {
  if (cutting.law != CuttingLaw::energy || cutting.erosion != ErosionMode::remove) {
    throw RunError("the reference knows law energy and erosion remove only, not " + name_of(cutting.law) + " and " +
                   name_of(cutting.erosion));
  }
  if (bone.fill.stored_bricks() > 0) throw RunError("the reference takes bone of whole voxels only");
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
    const Vec3i corner = RS_BRICK_SIDE * state_->lattice.coord(block.brick);
    for (rs_u64 rest = block.removed; rest != 0; rest &= rest - 1) {
      const auto place = static_cast<rs_i32>(block.detail << 6) + std::countr_zero(rest);
      const Vec3i voxel = corner + Vec3i(rs_offset_x(place), rs_offset_y(place), rs_offset_z(place));
      out.push_back(state_->grid.index(voxel));
    }
  }
  std::sort(out.begin(), out.end());
  return out;
}

void Reference::restore() {
  for (const RemovedBlock& block : removed()) {
    Brick& brick = state_->bricks[static_cast<std::size_t>(state_->slot_of_brick[block.brick])];
    brick.bone[2 * block.detail] |= static_cast<rs_u32>(block.removed);
    brick.bone[2 * block.detail + 1] |= static_cast<rs_u32>(block.removed >> 32);
    state_->occupy(state_->lattice.coord(block.brick));
  }
}

}  // namespace reamsim::reference
