#include "sim/engine/bricked/bricked_state.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "sim/base/error.h"
#include "sim/engine/common/dense_bone.h"

namespace reamsim {

// Host and device lay the structs out alike.
static_assert(sizeof(Brick) == 2 * 64 + 512);
static_assert(sizeof(RemovedBlock) == 16);
static_assert(FillBricks::kSide == RS_BRICK_SIDE);

namespace {

constexpr int kSide = RS_BRICK_SIDE;
constexpr int kManyPools = 16;
constexpr std::size_t kFillBytes = sizeof(rs_u16) * RS_BRICK_VOXELS;

std::size_t superbrick_count(const Vec3i& bricks) {
  const Vec3i n = (bricks.array() + 3) / 4;
  return static_cast<std::size_t>(n.x()) * static_cast<std::size_t>(n.y()) * static_cast<std::size_t>(n.z());
}

/// Writes a brick as the device has it; false where nothing is left in it.
bool fill_brick(const Voxmap& voxmap, const Vec3i& coord, const GradeBricks::Brick& grades, bool with_fill,
                cl_uchar* bytes) {
  Brick out{};
  std::array<rs_u16, RS_BRICK_VOXELS> fill{};
  const FillBricks::Brick* fills = voxmap.fill.brick(coord);
  bool left = false;
  for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
    const Vec3i voxel = BrickLattice::voxel_at(Vec3i::Zero(), offset);
    const auto place = static_cast<std::size_t>(rs_brick_offset(voxel.x(), voxel.y(), voxel.z()));
    const auto at = static_cast<std::size_t>(offset);
    out.grade[place] = grades[at];
    fill[place] = fills == nullptr ? FillBricks::kWhole : (*fills)[at];
    if (out.grade[place] == 0 || fill[place] == 0) continue;
    out.bone[place >> 5] |= 1U << (place & 31U);
    left = true;
  }
  std::memcpy(bytes, &out, sizeof out);
  if (with_fill) std::memcpy(bytes + sizeof out, fill.data(), kFillBytes);
  return left;
}

/// Marks a brick as holding bone; its place in the words is that of cut_bricked.cl.
void occupy(const Vec3i& brick, const Vec3i& superbricks, std::vector<cl_uint>& occupancy) {
  const Vec3i s = brick / 4;
  const auto word = static_cast<std::size_t>(
      2 * (s.x() + std::int64_t{superbricks.x()} * (s.y() + std::int64_t{superbricks.y()} * s.z())));
  const auto bit = static_cast<unsigned>((brick.x() & 3) | (brick.y() & 3) << 2 | (brick.z() & 3) << 4);
  occupancy[word + (bit >> 5)] |= 1U << (bit & 31U);
}

BrickPools plan_pools(const Voxmap& voxmap, FillStore fill, std::size_t largest_allocation) {
  BrickPools pools;
  pools.fill = fill == FillStore::none && partly_filled(voxmap) ? FillStore::bricks : fill;
  pools.brick_bytes = sizeof(Brick) + (pools.fill == FillStore::bricks ? kFillBytes : 0);
  pools.bricks = voxmap.grade.stored_bricks();
  pools.bits = 31;
  if (pools.bricks * pools.brick_bytes <= largest_allocation) return pools;
  pools.pools = kManyPools;
  // Where not even one brick fits, make_bricked_state() says so.
  pools.bits = std::max(0, static_cast<int>(std::bit_width(largest_allocation / pools.brick_bytes)) - 1);
  return pools;
}

std::size_t bytes_of(const BrickPools& pools, const Voxmap& voxmap, const PointShell& shell) {
  const std::size_t bricks = BrickLattice::over(voxmap.grid.dims).count();
  return pools.bricks * (pools.brick_bytes + 3 * sizeof(cl_uint)) + bricks * sizeof(cl_int) +
         8 * superbrick_count(voxmap.grade.brick_dims()) + 3 * shell.codes.size();
}

[[noreturn]] void does_not_fit(const cl::Device& device, const Voxmap& voxmap, std::size_t need, std::size_t have) {
  const double factor = std::cbrt(static_cast<double>(need) / static_cast<double>(have));
  const auto mb = [](std::size_t bytes) { return std::to_string(bytes / 1'000'000) + " MB"; };
  throw InputError({}, "bone.voxel_mm",
                   "the bone's bricks need " + mb(need) + " of the " + mb(have) + " of " + device.info().name,
                   "about " + std::to_string(voxmap.grid.voxel_mm * std::max(1.0, factor) * 1.05) + " mm would fit");
}

/// A buffer is never empty: nothing is uploaded as one zero, such as a cell without points.
template <class T>
cl::Buffer<T> upload(const cl::Device& device, std::vector<T> data, const char* what) {
  if (data.empty()) data.emplace_back();
  cl::Buffer<T> buffer(device, data.size(), what);
  buffer.write(device, data.data(), data.size());
  return buffer;
}

}  // namespace

std::string BrickPools::defines(KernelShape shape) const {
  return "-DRS_POOLS=" + std::to_string(pools) + " -DRS_POOL_BITS=" + std::to_string(bits) +
         (fill == FillStore::bricks ? " -DRS_BRICK_FILL" : "") + (shape == KernelShape::cpu ? " -DRS_CPU_SHAPE" : "");
}

void BrickedState::set_pools(cl::Kernel& kernel, cl_uint first_argument) const {
  for (int i = 0; i < layout.pools; ++i) {
    // Pools that the bone does not need are never looked up; the argument has to be some buffer.
    kernel.set(first_argument + static_cast<cl_uint>(i),
               pools[std::min(static_cast<std::size_t>(i), pools.size() - 1)]);
  }
}

std::size_t bricked_bytes(const Voxmap& voxmap, const Tool& tool, FillStore fill) {
  return bytes_of(plan_pools(voxmap, fill, SIZE_MAX), voxmap, tool.shell);
}

BrickedState make_bricked_state(const cl::Device& device, const Voxmap& voxmap, const Tool& tool, FillStore fill,
                                std::size_t largest_pool) {
  const std::size_t largest = std::min(device.info().max_allocation_bytes, largest_pool);
  BrickedState state;
  state.layout = plan_pools(voxmap, fill, largest);
  const std::size_t need = bytes_of(state.layout, voxmap, tool.shell);
  if (need > device.info().global_memory_bytes) {
    does_not_fit(device, voxmap, need, device.info().global_memory_bytes);
  }
  const std::size_t room = largest < state.layout.brick_bytes ? 0 : std::size_t{kManyPools} << state.layout.bits;
  if (state.layout.pools > 1 && state.layout.bricks > room) {
    does_not_fit(device, voxmap, state.layout.bricks * state.layout.brick_bytes,
                 state.layout.brick_bytes * kManyPools << state.layout.bits);
  }

  const Vec3i bricks = voxmap.grade.brick_dims();
  state.grid = voxmap.grid;
  state.bricks = {{bricks.x(), bricks.y(), bricks.z(), 0}};
  std::vector<cl_int> slot_of_brick(BrickLattice::over(voxmap.grid.dims).count(), -1);
  std::vector<cl_uint> lattice_of_slot;
  const BrickLattice lattice{bricks};
  voxmap.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick&) {
    const std::size_t index = lattice.index(coord);
    slot_of_brick[index] = static_cast<cl_int>(lattice_of_slot.size());
    lattice_of_slot.push_back(static_cast<cl_uint>(index));
  });
  state.slot_of_brick = upload(device, slot_of_brick, "the table of bricks");
  state.lattice_of_slot = upload(device, lattice_of_slot, "the bricks' places");
  const std::size_t per_pool = state.layout.pools == 1 ? state.layout.bricks : std::size_t{1} << state.layout.bits;
  for (std::size_t first = 0; first == 0 || first < state.layout.bricks; first += per_pool) {
    const std::size_t count = std::max<std::size_t>(1, std::min(per_pool, state.layout.bricks - first));
    state.pools.emplace_back(device, count * state.layout.brick_bytes, "the bone's bricks");
    if (per_pool == 0) break;
  }
  const std::size_t slots = std::max<std::size_t>(1, state.layout.bricks);
  state.listed = {device, slots, "the marks of touched bricks"};
  state.listed.clear(device, slots);
  state.touched_list = {device, slots, "the list of touched bricks"};
  state.occupancy = {device, 2 * superbrick_count(bricks), "the bricks' occupancy"};
  upload_bone(device, state, voxmap);

  const ShellCells shell = make_shell_cells(tool.shell, shell_cell_side(tool.shell.cell_mm / voxmap.grid.voxel_mm));
  state.cells = upload(device, shell.cells, "the shell's cells");
  state.runs = upload(device, shell.runs, "the shell's cells");
  state.offsets = upload(device, shell.offsets, "the point shell");
  state.profile = {device, make_profile_table(tool.profile, voxmap.grid.voxel_mm)};
  return state;
}

void upload_bone(const cl::Device& device, BrickedState& state, const Voxmap& voxmap) {
  const Vec3i bricks = voxmap.grade.brick_dims();
  const bool same = voxmap.grid.dims == state.grid.dims && voxmap.grade.stored_bricks() == state.layout.bricks &&
                    (state.layout.fill != FillStore::none || !partly_filled(voxmap));
  if (!same) throw RunError("this is not the bone that the engine was made for: its memory was planned for another");
  constexpr std::size_t kChunk = 4096;  // bricks written at once
  const std::size_t bytes = state.layout.brick_bytes;
  std::vector<cl_uchar> chunk(kChunk * bytes);
  std::vector<cl_uint> occupancy(state.occupancy.count(), 0);
  const Vec3i superbricks = (bricks.array() + 3) / 4;
  std::size_t slot = 0, first = 0;
  const auto flush = [&] {
    const std::size_t pool = first >> state.layout.bits, within = first & ((std::size_t{1} << state.layout.bits) - 1);
    if (slot > first) state.pools[pool].write(device, chunk.data(), (slot - first) * bytes, within * bytes);
    first = slot;
  };
  voxmap.grade.for_each_brick([&](const Vec3i& brick, const GradeBricks::Brick& grades) {
    if (fill_brick(voxmap, brick, grades, state.layout.fill == FillStore::bricks,
                   chunk.data() + (slot - first) * bytes)) {
      occupy(brick, superbricks, occupancy);
    }
    ++slot;
    const bool pool_ends = (slot & ((std::size_t{1} << state.layout.bits) - 1)) == 0;
    if (slot - first == kChunk || pool_ends) flush();
  });
  flush();
  state.occupancy.write(device, occupancy.data(), occupancy.size());
}

void upload_bricks_of(const cl::Device& device, BrickedState& state, const Voxmap& voxmap,
                      const RemovedFrames& voxels) {
  if (voxels.empty()) return;
  const BrickLattice lattice = BrickLattice::over(voxmap.grid.dims);
  std::vector<std::size_t> touched;
  touched.reserve(voxels.size());
  for (const auto& [voxel, frame] : voxels) {
    touched.push_back(lattice.index(BrickLattice::brick_of(voxmap.grid.coord(voxel))));
  }
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());

  const std::size_t bytes = state.layout.brick_bytes;
  const Vec3i superbricks = (lattice.dims.array() + 3) / 4;
  std::vector<cl_int> slots(state.slot_of_brick.count());
  std::vector<cl_uint> occupancy(state.occupancy.count());
  state.slot_of_brick.read(device, slots.data(), slots.size());
  state.occupancy.read(device, occupancy.data(), occupancy.size());
  std::vector<cl_uchar> record(bytes);
  for (const std::size_t index : touched) {
    const Vec3i brick = lattice.coord(index);
    const auto slot = static_cast<std::size_t>(slots[index]);
    const std::size_t pool = slot >> state.layout.bits, within = slot & ((std::size_t{1} << state.layout.bits) - 1);
    const bool left =
        fill_brick(voxmap, brick, *voxmap.grade.brick(brick), state.layout.fill == FillStore::bricks, record.data());
    state.pools[pool].write(device, record.data(), bytes, within * bytes);
    if (left) occupy(brick, superbricks, occupancy);
  }
  state.occupancy.write(device, occupancy.data(), occupancy.size());
}

void read_bricked_fill(const cl::Device& device, const BrickedState& state, Voxmap& voxmap) {
  if (state.layout.fill != FillStore::bricks) return;
  const std::size_t bytes = state.layout.brick_bytes;
  std::vector<cl_uchar> record(bytes);
  std::array<rs_u16, RS_BRICK_VOXELS> fill{};
  std::size_t slot = 0;
  voxmap.grade.for_each_brick([&](const Vec3i& brick, const GradeBricks::Brick& grades) {
    const std::size_t pool = slot >> state.layout.bits, within = slot & ((std::size_t{1} << state.layout.bits) - 1);
    state.pools[pool].read(device, record.data(), bytes, within * bytes);
    std::memcpy(fill.data(), record.data() + sizeof(Brick), kFillBytes);
    ++slot;
    for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
      if (grades[static_cast<std::size_t>(offset)] == 0) continue;
      const Vec3i voxel = BrickLattice::voxel_at(brick, offset);
      voxmap.fill.set(voxel, fill[static_cast<std::size_t>(rs_brick_offset(voxel.x(), voxel.y(), voxel.z()))]);
    }
  });
}

}  // namespace reamsim
