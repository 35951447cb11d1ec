// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* rs_real and rs_int of kernels/lanes.h for C++ (GCC, Clang): RS_LANES values in a vector of the compiler. RS_LANES
 * must be what the instruction set of the file has: 16 with AVX-512 (F, DQ), 8 with AVX2 and FMA, 4 otherwise. All
 * functions are static, because another file may have them for another instruction set. */
#ifndef REAMSIM_REFERENCE_HOST_LANES_H
#define REAMSIM_REFERENCE_HOST_LANES_H

#include "kernels/shared.h"
#ifdef __SSE2__
#include <immintrin.h>
#endif

typedef float rs_real __attribute__((vector_size(4 * RS_LANES)));
typedef rs_i32 rs_int __attribute__((vector_size(4 * RS_LANES)));
typedef rs_i64 rs_sum __attribute__((vector_size(8 * RS_LANES)));
#define RS_TO_SUM(value) __builtin_convertvector(value, rs_sum)
#define RS_TO_INT(value) __builtin_convertvector(value, rs_int)
#define RS_TO_REAL(value) __builtin_convertvector(value, rs_real)
#define RS_BITS_OF(real) ((rs_int)(real))
#define RS_REAL_OF(bits) ((rs_real)(bits))
/* Minus zero, because x - 0 is x for every x, so that the compiler omits it. */
#define RS_REAL(scalar) ((float)(scalar)-rs_real{})
#define RS_INT(scalar) ((rs_i32)(scalar)-rs_int{})
#define RS_SUM(scalar) ((rs_i64)(scalar)-rs_sum{})

RS_INLINE rs_i64 rs_lane_sum(rs_sum lanes) {
  rs_i64 out = 0;
  for (int l = 0; l < RS_LANES; ++l) out += lanes[l];
  return out;
}

/* rs_lane_bits, rs_bits_less: the lanes in which a comparison holds, a < b holds, as bits. rs_root: correctly rounded.
 * rs_min(a, b) is a < b ? a : b, rs_max(a, b) is a < b ? b : a, also for zeros and NaN. */
#if RS_LANES == 16 && defined(__AVX512DQ__)
RS_INLINE rs_u32 rs_lane_bits(rs_int condition) {
  return _mm512_movepi32_mask((__m512i)condition);
}
RS_INLINE rs_u32 rs_bits_less(rs_int a, rs_int b) {
  return _mm512_cmplt_epi32_mask((__m512i)a, (__m512i)b);
}
/* The compiler makes two instructions of the conditional expressions for these. */
#define RS_HAS_MIN
RS_INLINE rs_real rs_min(rs_real a, rs_real b) {
  return _mm512_maskz_min_ps(0xffff, a, b);
}
RS_INLINE rs_real rs_max(rs_real a, rs_real b) {
  return _mm512_maskz_max_ps(0xffff, b, a);
}
RS_INLINE rs_real rs_root(rs_real x) {
  return _mm512_maskz_sqrt_ps(0xffff, x); /* GCC 12 takes the one without mask for uninitialised (bug 105593) */
}
#define RS_HAS_FMA
RS_INLINE rs_real rs_fma(rs_real a, rs_real b, rs_real c) {
  return _mm512_fmadd_ps(a, b, c);
}
#elif RS_LANES == 8 && defined(__AVX2__)
RS_INLINE rs_u32 rs_lane_bits(rs_int condition) {
  return (rs_u32)_mm256_movemask_ps((__m256)condition);
}
RS_INLINE rs_real rs_root(rs_real x) {
  return _mm256_sqrt_ps(x);
}
#define RS_HAS_FMA
RS_INLINE rs_real rs_fma(rs_real a, rs_real b, rs_real c) {
  return _mm256_fmadd_ps(a, b, c);
}
#elif RS_LANES == 4 && defined(__SSE2__)
RS_INLINE rs_u32 rs_lane_bits(rs_int condition) {
  return (rs_u32)_mm_movemask_ps((__m128)condition);
}
RS_INLINE rs_real rs_root(rs_real x) {
  return _mm_sqrt_ps(x);
}
#else
RS_INLINE rs_u32 rs_lane_bits(rs_int condition) {
  rs_u32 bits = 0;
  for (int lane = 0; lane < RS_LANES; ++lane) bits |= (rs_u32)(condition[lane] & 1) << lane;
  return bits;
}
RS_INLINE rs_real rs_root(rs_real x) {
  for (int lane = 0; lane < RS_LANES; ++lane) x[lane] = __builtin_sqrtf(x[lane]);
  return x;
}
#endif
#ifndef RS_HAS_MIN
RS_INLINE rs_u32 rs_bits_less(rs_int a, rs_int b) {
  return rs_lane_bits(a < b);
}
#endif
#ifndef RS_HAS_FMA
RS_INLINE rs_real rs_fma(rs_real a, rs_real b, rs_real c) {
  for (int lane = 0; lane < RS_LANES; ++lane) c[lane] = __builtin_fmaf(a[lane], b[lane], c[lane]);
  return c;
}
#endif
RS_INLINE rs_real rs_floor(rs_real x) {
  for (int lane = 0; lane < RS_LANES; ++lane) x[lane] = __builtin_floorf(x[lane]);
  return x;
}

RS_INLINE float rs_root(float x) {
  return __builtin_sqrtf(x);
}
RS_INLINE double rs_floor(double x) {
  return __builtin_floor(x);
}
RS_INLINE float rs_fma(float a, float b, float c) {
  return __builtin_fmaf(a, b, c);
}

#define RS_ANY(condition) (rs_lane_bits(condition) != 0)
#define RS_FMA(a, b, c) rs_fma(a, b, c)
#undef RS_SQRT
#define RS_SQRT rs_root
#undef RS_FLOOR
#define RS_FLOOR rs_floor

#endif
