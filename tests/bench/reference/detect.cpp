// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The narrow phase of `bricked` in C++: detect_bricked.cl as it runs on a CPU, over the same structures and with the
// same operations. Points of cells that can meet bone are gathered as bits of a window of 32×32×32 voxels, sixteen
// points in the lanes of a vector where the instruction set has them, and then handed to the bricks.
#include "tests/bench/reference/frame.h"
#include "tests/bench/reference/lanes.h"

namespace reamsim::reference::REAMSIM_TARGET {

namespace {

constexpr int kWindowBlocks = 512;  // of 4×4×4 voxels

/// Where a cell's points lie: fixed point, and voxels.
struct Reach {
  rs_i64 first[3];
  rs_i32 low[3], high[3];
};

rs_i32 least(rs_i32 a, rs_i32 b) {
  return a < b ? a : b;
}
rs_i32 most(rs_i32 a, rs_i32 b) {
  return a > b ? a : b;
}

Reach reach_of(const SubstepArgs& a, const ShellCell& cell) {
  Reach reach;
  for (int i = 0; i < 3; ++i) {
    const rs_i64* row = a.voxel_from_cell + 3 * i;
    const rs_i64 first = a.voxel_origin[i] + row[0] * cell.first[0] + row[1] * cell.first[1] + row[2] * cell.first[2];
    rs_i64 low = first, high = first;
    for (int j = 0; j < 3; ++j) {
      const rs_i64 step = row[j] * cell.span[j];
      (step < 0 ? low : high) += step;
    }
    reach.first[i] = first;
    reach.low[i] = static_cast<rs_i32>(low >> RS_POSITION_BITS);
    reach.high[i] = static_cast<rs_i32>(high >> RS_POSITION_BITS);
  }
  return reach;
}

bool meets_lattice(const SubstepArgs& a, const Reach& reach) {
  bool meets = true;
  for (int i = 0; i < 3; ++i) meets = meets && reach.high[i] >= 0 && reach.low[i] < a.dims[i];
  return meets;
}

bool meets_voi(const SubstepArgs& a, const ShellCell& cell) {
  bool meets = true;
  for (int i = 0; i < 3; ++i)
    meets = meets && cell.first[i] <= a.voi_max[i] && cell.first[i] + cell.span[i] >= a.voi_min[i];
  return meets;
}

/// Four bits: which of the bricks 4s…4s+3 lie in low…high.
rs_u32 nibble(rs_i32 s, rs_i32 low, rs_i32 high) {
  const rs_i32 first = most(low - 4 * s, 0), last = least(high - 4 * s, 3);
  return ((2U << last) - 1U) & ~((1U << first) - 1U);
}

/// Is there a brick with bone among those that the box of voxels touches?
bool meets_bone(const Frame& f, const Reach& reach) {
  rs_i32 low[3], high[3];
  for (int i = 0; i < 3; ++i) {
    low[i] = most(reach.low[i], 0) >> 3;
    high[i] = least(reach.high[i], f.args->dims[i] - 1) >> 3;
  }
  const rs_i32 nx = (f.bone.brick_dims[0] + 3) >> 2, ny = (f.bone.brick_dims[1] + 3) >> 2;
  rs_u32 found = 0;
  for (rs_i32 sz = low[2] >> 2; sz <= high[2] >> 2; ++sz) {
    const rs_u32 mz = nibble(sz, low[2], high[2]);
    for (rs_i32 sy = low[1] >> 2; sy <= high[1] >> 2; ++sy) {
      const rs_u32 my = nibble(sy, low[1], high[1]);
      const rs_u32 rows = ((my & 1U) | (my & 2U) << 3 | (my & 4U) << 6 | (my & 8U) << 9) * 0xfU;
      for (rs_i32 sx = low[0] >> 2; sx <= high[0] >> 2; ++sx) {
        const rs_u32 layer = rows & (nibble(sx, low[0], high[0]) * 0x1111U);
        const rs_u32* words = f.bone.occupancy + 2 * (sx + nx * (sy + ny * sz));
        const rs_u32 lower = ((mz & 1U) | (mz & 2U) << 15) * layer, upper = ((mz >> 2 & 1U) | (mz & 8U) << 13) * layer;
        found |= (words[0] & lower) | (words[1] & upper);
      }
    }
  }
  return found != 0;
}

/// The points of a cell as bits of the window whose lowest voxel is `origin`.
void gather(const Frame& f, const ShellCell& cell, const Reach& reach, const rs_i32* origin, rs_u64* window) {
  rs_i32 base[3], step[9];
  for (int i = 0; i < 3; ++i) {
    base[i] = static_cast<rs_i32>(reach.first[i] - (static_cast<rs_i64>(origin[i]) << RS_POSITION_BITS));
    for (int j = 0; j < 3; ++j) step[3 * i + j] = static_cast<rs_i32>(f.args->voxel_from_cell[3 * i + j]);
  }
  for (rs_u32 p = cell.begin; p < cell.begin + cell.count; p += kLanes) {
    const Ints o = ints_of(f.offsets + p);
    const Ints x = o & 31, y = o >> 5 & 31, z = o >> 10;
    const Ints i = (base[0] + x * step[0] + y * step[1] + z * step[2]) >> RS_POSITION_BITS;
    const Ints j = (base[1] + x * step[3] + y * step[4] + z * step[5]) >> RS_POSITION_BITS;
    const Ints k = (base[2] + x * step[6] + y * step[7] + z * step[8]) >> RS_POSITION_BITS;
    const Ints block = i >> 2 | (j >> 2) << 3 | (k >> 2) << 6;
    const Ints bit = (i & 3) | (j & 3) << 2 | (k & 3) << 4;
    rs_i32 place[kLanes];
    store(block << 6 | bit, place);
    for (const rs_i32 at : place) window[at >> 6] |= rs_u64{1} << (at & 63);
  }
}

/// Notes that the voxels `bits` of half a block are touched, where they are bone.
void touch(Frame& f, rs_i32 slot, int word, rs_u32 bits) {
  Brick& brick = f.bone.bricks[slot];
  const rs_u32 bone = bits & brick.bone[word];
  if (bone == 0) return;
  // Who touches a word first may be the first in the brick.
  if (__atomic_fetch_or(&brick.touched[word], bone, __ATOMIC_RELAXED) != 0) return;
  if (__atomic_exchange_n(&f.listed[slot], 1U, __ATOMIC_RELAXED) != 0) return;
  f.touched_list[__atomic_fetch_add(&f.touched_count, 1U, __ATOMIC_RELAXED)] = static_cast<rs_u32>(slot);
}

/// Slot of the brick that holds a block (coordinates in blocks of 4 voxels), or -1.
rs_i32 slot_of_block(const Frame& f, rs_i32 x, rs_i32 y, rs_i32 z) {
  const rs_i32 bx = x >> 1, by = y >> 1, bz = z >> 1;
  const rs_i32* n = f.bone.brick_dims;
  if (bx < 0 || by < 0 || bz < 0 || bx >= n[0] || by >= n[1] || bz >= n[2]) return -1;
  return f.bone.slot_of_brick[bx + static_cast<rs_i64>(n[0]) * (by + static_cast<rs_i64>(n[1]) * bz)];
}

/// Hands the window's bits to the bricks and leaves it empty.
void flush(Frame& f, const Reach& reach, const rs_i32* origin, rs_u64* window) {
  const rs_i32 ox = origin[0] >> 2, oy = origin[1] >> 2, oz = origin[2] >> 2;
  const rs_i32 last_y = (reach.high[1] >> 2) - oy, last_z = (reach.high[2] >> 2) - oz;
  for (rs_i32 z = 0; z <= last_z; ++z) {
    for (rs_i32 y = 0; y <= last_y; ++y) {
      rs_u64* row = window + 8 * (y + 8 * z);
      rs_u64 each[8], any = 0;
      for (int x = 0; x < 8; ++x) {
        each[x] = row[x];
        any |= row[x];
        row[x] = 0;
      }
      if (any == 0) continue;
      for (rs_i32 x = 0; x < 8; ++x) {
        if (each[x] == 0) continue;
        const rs_i32 slot = slot_of_block(f, ox + x, oy + y, oz + z);
        if (slot < 0) continue;
        const int word = 2 * (((ox + x) & 1) | ((oy + y) & 1) << 1 | ((oz + z) & 1) << 2);
        touch(f, slot, word, static_cast<rs_u32>(each[x]));
        touch(f, slot, word + 1, static_cast<rs_u32>(each[x] >> 32));
      }
    }
  }
}

bool meets(const Frame& f, const ShellCell& cell, const Reach& reach) {
  return meets_voi(*f.args, cell) && meets_lattice(*f.args, reach) && meets_bone(f, reach);
}

}  // namespace

void detect(Frame& f) {
  alignas(64) rs_u64 window[kWindowBlocks] = {};
  for (;;) {
    const rs_u32 run = __atomic_fetch_add(&f.next_run, 1U, __ATOMIC_RELAXED);
    if (run >= f.run_count) return;
    const ShellCell& whole = f.runs[run];
    if (!meets(f, whole, reach_of(*f.args, whole))) continue;
    for (rs_u32 c = whole.begin; c < whole.begin + whole.count; ++c) {
      const ShellCell& cell = f.cells[c];
      if (!meets_voi(*f.args, cell)) continue;
      const Reach reach = reach_of(*f.args, cell);
      if (!meets_lattice(*f.args, reach) || !meets_bone(f, reach)) continue;
      const rs_i32 origin[3] = {reach.low[0] & ~3, reach.low[1] & ~3, reach.low[2] & ~3};
      gather(f, cell, reach, origin, window);
      flush(f, reach, origin, window);
    }
  }
}

}  // namespace reamsim::reference::REAMSIM_TARGET
