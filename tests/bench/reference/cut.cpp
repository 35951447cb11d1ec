// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The cut of `bricked` in C++: cut_bricked.cl as it runs on a CPU, over the same structures, with the cutting law of
// kernels/cut_law.h for vectors of the compiler.
#include "kernels/cut_law.h"
#include "tests/bench/reference/brick_places.h"
#include "tests/bench/reference/frame.h"
#include "tests/bench/reference/lanes.h"

namespace reamsim::reference::REAMSIM_TARGET {

namespace {

constexpr rs_u32 kBricksAtOnce = 8;  // that a thread takes
constexpr rs_u32 kWaiting = 32;

/// What a thread adds up before it adds to the frame. Records of removed voxels wait until there are some.
struct Tally {
  Sum force[3], torque[3], floor_energy;
  rs_i64 energy = 0, contacts = 0;
  RemovedBlock waiting[kWaiting];
  rs_u32 waiting_count = 0;
};

// ---- The law ----

/// rs_add_force().
void add_force(Tally& tally, const Reals* f, const Reals* p) {
  constexpr auto kForce = static_cast<float>(RS_FORCE_SCALE), kTorque = static_cast<float>(RS_TORQUE_SCALE);
  for (int i = 0; i < 3; ++i) tally.force[i].add(f[i] * kForce);
  tally.torque[0].add((p[1] * f[2] - p[2] * f[1]) * kTorque);
  tally.torque[1].add((p[2] * f[0] - p[0] * f[2]) * kTorque);
  tally.torque[2].add((p[0] * f[1] - p[1] * f[0]) * kTorque);
}

/// rs_cut_force(), with sums in halves of vectors.
void cut_force(const SubstepArgs& a, const OutlineView& outline, PieceList list, const Reals* p, Reals energy,
               Tally& tally) {
  Reals n[3];
  rs_outline_normal(&outline, list, p, n);
  const CutResponse found = rs_cut_response(&a, n, p, energy);
  tally.floor_energy.add(found.floor_energy * static_cast<float>(RS_ENERGY_SCALE));
  add_force(tally, found.force, p);
}

// ---- Bricks ----

void hand_over_removed(Frame& f, Tally& tally) {
  if (tally.waiting_count == 0) return;
  RemovedBlock* to = f.removed + __atomic_fetch_add(&f.removed_count, tally.waiting_count, __ATOMIC_RELAXED);
  __builtin_memcpy(to, tally.waiting, sizeof(RemovedBlock) * tally.waiting_count);
  tally.waiting_count = 0;
}

/// Removes the listed voxels from the brick, and lists their energies.
void remove_listed(Frame& f, rs_u32 slot, const rs_u16* places, int count, float* energies, Tally& tally) {
  Brick& brick = f.bone.bricks[slot];
  for (int i = 0; i < count; ++i) {
    const rs_u8 grade = brick.grade[places[i]];
    tally.energy += f.units[grade];
    energies[i] = rs_energy_mj(f.units[grade]);
  }
  tally.contacts += count;
  store(Reals{}, energies + count);
  for (rs_u32 block = 0; block < RS_BRICK_WORDS / 2; ++block) {
    const rs_u32 low = brick.touched[2 * block], high = brick.touched[2 * block + 1];
    if ((low | high) == 0) continue;
    brick.bone[2 * block] &= ~low;
    brick.bone[2 * block + 1] &= ~high;
    brick.touched[2 * block] = brick.touched[2 * block + 1] = 0;
    if (tally.waiting_count == kWaiting) hand_over_removed(f, tally);
    tally.waiting[tally.waiting_count++] = {f.bone.lattice_of_slot[slot], block, low | static_cast<rs_u64>(high) << 32};
  }
}

/// Accumulates the cut forces of the listed voxels of the brick at voxel (x, y, z).
void accumulate_cut_forces(const Frame& f, const rs_i32* voxel, const rs_u16* places, const float* energies, int count,
                           Tally& tally) {
  const SubstepArgs& a = *f.args;
  BrickMiddle middle;
  rs_brick_in_tool(&a, voxel[0], voxel[1], voxel[2], &middle);
  const PieceList list = rs_pieces_near_brick(&f.outline, &middle);
  for (int i = 0; i < count; i += kLanes) {
    const Ints place = ints_of(places + i);
    const Reals x = offset_x(place), y = offset_y(place), z = offset_z(place);
    Reals p[3];
    rs_voxel_in_tool(&a, &middle, x, y, z, p);
    cut_force(a, f.outline, list, p, load<Reals>(energies + i), tally);
  }
}

void cut_brick(Frame& f, rs_u32 slot, Tally& tally) {
  rs_u16 places[RS_BRICK_VOXELS + kPadding];
  float energies[RS_BRICK_VOXELS + kPadding];
  Brick& brick = f.bone.bricks[slot];
  f.listed[slot] = 0;
  const BrickPosition at = position_of(f.bone, slot);
  const int count = list_places(brick.touched, f.bits_of_byte, places);
  remove_listed(f, slot, places, count, energies, tally);
  const rs_i32 voxel[3] = {RS_BRICK_SIDE * at.x, RS_BRICK_SIDE * at.y, RS_BRICK_SIDE * at.z};
  accumulate_cut_forces(f, voxel, places, energies, count, tally);
  clear_if_empty(f.bone, brick, at);
}

void add(rs_i64& total, rs_i64 part) {
  __atomic_fetch_add(&total, part, __ATOMIC_RELAXED);
}

void add_to_frame(Frame& f, const Tally& tally) {
  for (int c = 0; c < 3; ++c) {
    add(f.sums.force[c], tally.force[c].total());
    add(f.sums.torque[c], tally.torque[c].total());
  }
  add(f.sums.energy, tally.energy);
  add(f.sums.floor_energy, tally.floor_energy.total());
  add(f.sums.removed, RS_WHOLE_FILL * tally.contacts);
  add(f.sums.contacts, tally.contacts);
}

}  // namespace

void cut(Frame& f) {
  Tally tally;
  for (;;) {
    const rs_u32 first = __atomic_fetch_add(&f.next_touched, kBricksAtOnce, __ATOMIC_RELAXED);
    if (first >= f.touched_count) break;
    const rs_u32 rest = f.touched_count - first, count = rest < kBricksAtOnce ? rest : kBricksAtOnce;
    for (rs_u32 t = first; t < first + count; ++t) cut_brick(f, f.touched_list[t], tally);
  }
  hand_over_removed(f, tally);
  add_to_frame(f, tally);
}

}  // namespace reamsim::reference::REAMSIM_TARGET
