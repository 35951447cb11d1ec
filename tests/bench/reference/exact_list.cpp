// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The broad phase of `exact` in C++: list_bricks.cl over the same structures.
#include "kernels/reach.h"
#include "tests/bench/reference/exact_visit.h"
#include "tests/bench/reference/lanes.h"

namespace reamsim::reference::REAMSIM_TARGET {

namespace {

/// Lists the bricks of a superbrick that the surface can intersect.
void list_superbrick(ExactVisit& v, rs_i32 sx, rs_i32 sy, rs_i32 sz) {
  const SubstepArgs* a = v.args;
  const rs_i32* n = v.bone.brick_dims;
  const rs_u32* words = v.bone.occupancy + 2 * (sx + ((n[0] + 3) >> 2) * (sy + ((n[1] + 3) >> 2) * sz));
  const rs_u64 occupied = words[0] | static_cast<rs_u64>(words[1]) << 32;
  if (occupied == 0) return;
  float p[3];
  rs_box_middle(a, 32 * sx, 32 * sy, 32 * sz, 32, p);
  if (rs_near_surface(v.coarse, v.distances, p, RS_SUPERBRICK_RADIUS * a->voxel_mm + v.shift_mm) == 0) return;
  rs_u32 found[64], count = 0;
  for (rs_u64 rest = occupied; rest != 0; rest &= rest - 1) {
    const int bit = __builtin_ctzll(rest);
    const rs_i32 x = 4 * sx + (bit & 3), y = 4 * sy + (bit >> 2 & 3), z = 4 * sz + (bit >> 4);
    rs_box_middle(a, 8 * x, 8 * y, 8 * z, 8, p);
    if (rs_near_surface(v.coarse, v.distances, p, RS_BRICK_RADIUS * a->voxel_mm + v.shift_mm) == 0) continue;
    const rs_i64 index = x + static_cast<rs_i64>(n[0]) * (y + static_cast<rs_i64>(n[1]) * z);
    found[count++] = static_cast<rs_u32>(v.bone.slot_of_brick[index]);
  }
  if (count == 0) return;
  rs_u32* to = v.listed + __atomic_fetch_add(&v.listed_count, count, __ATOMIC_RELAXED);
  __builtin_memcpy(to, found, sizeof(rs_u32) * count);
}

}  // namespace

void list_bricks(ExactVisit& visit) {
  const auto nx = static_cast<rs_u32>(visit.supers[0]), ny = static_cast<rs_u32>(visit.supers[1]),
             nz = static_cast<rs_u32>(visit.supers[2]);
  for (;;) {
    const rs_u32 row = __atomic_fetch_add(&visit.next_super, 1U, __ATOMIC_RELAXED);
    if (row >= ny * nz) return;
    for (rs_u32 x = 0; x < nx; ++x) {
      list_superbrick(visit, visit.first_super[0] + static_cast<rs_i32>(x),
                      visit.first_super[1] + static_cast<rs_i32>(row % ny),
                      visit.first_super[2] + static_cast<rs_i32>(row / ny));
    }
  }
}

}  // namespace reamsim::reference::REAMSIM_TARGET
