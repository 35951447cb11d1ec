// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "kernels/lanes.h"
#include "tests/bench/reference/frame.h"

// Vectors of the compiler as wide as the instruction set has them (RS_LANES, host_lanes.h). The passes are
// compiled once per instruction set, with REAMSIM_TARGET the namespace that everything stands in, so that no two of
// them share an inline function. The functions of kernels/ are static.
namespace reamsim::reference::REAMSIM_TARGET {

// The number of lanes does not matter to the sums: the part of each voxel is the same, and lanes are added as integers.
constexpr int kLanes = RS_LANES;
static_assert(kPadding % kLanes == 0);

using Reals = rs_real;
using Ints = rs_int;
typedef float HalfOfReals __attribute__((vector_size(2 * kLanes)));
typedef rs_u16 Shorts __attribute__((vector_size(2 * kLanes)));
typedef rs_i64 HalfOfLongs __attribute__((vector_size(4 * kLanes)));

/// A vector from memory, whatever its alignment.
template <class Vector, class Element>
inline Vector load(const Element* from) {
  Vector out;
  __builtin_memcpy(&out, from, sizeof out);
  return out;
}

template <class Vector, class Element>
inline void store(const Vector& vector, Element* to) {
  __builtin_memcpy(to, &vector, sizeof vector);
}

inline Ints ints_of(const rs_u16* from) {
  return __builtin_convertvector(load<Shorts>(from), Ints);
}

/// A sum of 64-bit integers, by lane.
struct Sum {
  HalfOfLongs low{}, high{};

  /// Adds each lane of `value`, cut to an integer.
  void add(Reals value) {
    HalfOfReals halves[2];
    store(value, halves);
    low += __builtin_convertvector(halves[0], HalfOfLongs);
    high += __builtin_convertvector(halves[1], HalfOfLongs);
  }
  rs_i64 total() const {
    const HalfOfLongs both = low + high;
    rs_i64 out = 0;
    for (int l = 0; l < kLanes / 2; ++l) out += both[l];
    return out;
  }
};

}  // namespace reamsim::reference::REAMSIM_TARGET
