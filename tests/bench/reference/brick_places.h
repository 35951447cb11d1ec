// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "kernels/cut_law.h"
#include "tests/bench/reference/frame.h"
#include "tests/bench/reference/lanes.h"

// Bricks and the places of their voxels (rs_brick_offset), for passes that cut.
namespace reamsim::reference::REAMSIM_TARGET {

typedef rs_u8 Bytes __attribute__((vector_size(8)));
typedef rs_u16 Places __attribute__((vector_size(16)));

// ---- Coordinates of voxels within their brick ----

inline Reals offset_x(Ints place) {
  return RS_TO_REAL((place >> 6 & 1) << 2 | (place & 3));
}
inline Reals offset_y(Ints place) {
  return RS_TO_REAL((place >> 7 & 1) << 2 | (place >> 2 & 3));
}
inline Reals offset_z(Ints place) {
  return RS_TO_REAL((place >> 8 & 1) << 2 | (place >> 4 & 3));
}

/// Lists the places of the set bits of a brick in ascending order, padded with copies of the first to a multiple of the
/// lanes. Returns their number. `bits_of_byte`: bits_of_bytes().
inline int list_places(const rs_u32* words, const rs_u64* bits_of_byte, rs_u16* places) {
  int count = 0;
  for (int w = 0; w < RS_BRICK_WORDS; ++w) {
    const rs_u32 word = words[w];
    if (word == 0) continue;
    for (int b = 0; b < 4; ++b) {
      const rs_u32 byte = word >> 8 * b & 0xffU;
      const Places bits = __builtin_convertvector(load<Bytes>(bits_of_byte + byte), Places);
      store(bits + static_cast<rs_u16>(32 * w + 8 * b), places + count);
      count += __builtin_popcount(byte);
    }
  }
  store(Shorts{} + places[0], places + count);
  return count;
}

/// Place of a brick in the lattice of bricks.
struct BrickPosition {
  rs_i32 x, y, z;
};

inline BrickPosition position_of(const BoneArrays& bone, rs_u32 slot) {
  const rs_u32 index = bone.lattice_of_slot[slot];
  const auto nx = static_cast<rs_u32>(bone.brick_dims[0]), ny = static_cast<rs_u32>(bone.brick_dims[1]);
  const rs_u32 row = index / nx;
  return {static_cast<rs_i32>(index % nx), static_cast<rs_i32>(row % ny), static_cast<rs_i32>(row / ny)};
}

/// Clears the occupancy bit of an empty brick.
inline void clear_if_empty(const BoneArrays& bone, const Brick& brick, const BrickPosition& at) {
  rs_u32 remaining = 0;
  for (const rs_u32 word : brick.bone) remaining |= word;
  if (remaining != 0) return;
  const rs_i32 nx = (bone.brick_dims[0] + 3) >> 2, ny = (bone.brick_dims[1] + 3) >> 2;
  const rs_i32 superbrick = (at.x >> 2) + nx * ((at.y >> 2) + ny * (at.z >> 2));
  const auto bit = static_cast<rs_u32>((at.x & 3) | (at.y & 3) << 2 | (at.z & 3) << 4);
  __atomic_fetch_and(&bone.occupancy[2 * superbrick + static_cast<rs_i32>(bit >> 5)], ~(1U << (bit & 31U)),
                     __ATOMIC_RELAXED);
}

}  // namespace reamsim::reference::REAMSIM_TARGET
