#pragma once

#ifdef __SSE2__
#include <immintrin.h>
#else
#include <math.h>
#endif

#include "tests/bench/reference/frame.h"

// Vectors of the compiler as wide as the instruction set has them. The passes are compiled once per instruction set,
// with REAMSIM_TARGET the namespace that everything stands in, so that no two of them share an inline function.
namespace reamsim::reference::REAMSIM_TARGET {

// The number of lanes does not matter to the sums: each voxel's part is the same, and lanes are added as integers.
#if defined(__AVX512F__)
constexpr int kLanes = 16;
#elif defined(__AVX2__)
constexpr int kLanes = 8;
#else
constexpr int kLanes = 4;
#endif
static_assert(kPadding % kLanes == 0);

typedef float Reals __attribute__((vector_size(4 * kLanes)));
typedef float HalfOfReals __attribute__((vector_size(2 * kLanes)));
typedef rs_i32 Ints __attribute__((vector_size(4 * kLanes)));
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

/// The correctly rounded root of each lane.
inline Reals root(Reals value) {
#if defined(__AVX512F__)
  return _mm512_maskz_sqrt_ps(0xffff, value);  // GCC 12 takes the one without mask for uninitialised (bug 105593)
#elif defined(__AVX2__)
  return _mm256_sqrt_ps(value);
#elif defined(__SSE2__)
  return _mm_sqrt_ps(value);
#else
  for (int l = 0; l < kLanes; ++l) value[l] = sqrtf(value[l]);
  return value;
#endif
}

/// Whether a condition holds in any lane.
inline bool any(Ints condition) {
  rs_i32 out = 0;
  for (int l = 0; l < kLanes; ++l) out |= condition[l];
  return out != 0;
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
