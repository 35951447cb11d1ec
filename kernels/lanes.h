// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* Arithmetic that is the same for the host, a single work-item, and voxels in the lanes of a vector (RS_LANES of them:
 * 16 in a kernel; 4, 8 or 16 in C++, as wide as the instruction set): the same operations in the same order, and so the
 * same bits. */
#ifndef REAMSIM_KERNELS_LANES_H
#define REAMSIM_KERNELS_LANES_H

#include "shared.h"
#ifndef __OPENCL_C_VERSION__
#include <string.h>
#endif

#if defined(RS_LANES) && defined(__OPENCL_C_VERSION__)
typedef float16 rs_real;
typedef int16 rs_int;
typedef long16 rs_sum;
#define RS_TO_SUM(value) convert_long16(value)
#define RS_TO_INT(value) convert_int16(value)
#define RS_TO_REAL(value) convert_float16(value)
#define RS_BITS_OF(real) as_int16(real)
#define RS_REAL_OF(bits) as_float16(bits)
#define RS_FMA(a, b, c) fma(a, b, c)

RS_INLINE rs_i64 rs_lane_sum(rs_sum lanes) {
  const long8 eight = lanes.lo + lanes.hi;
  const long4 four = eight.lo + eight.hi;
  return four.x + four.y + four.z + four.w;
}

/* The lanes in which a condition holds, as bits. PoCL's any() branches on each lane. */
#if defined(__AVX512DQ__) /* a compiler for such a processor, as PoCL's */
RS_INLINE rs_u32 rs_lane_bits(rs_int condition) {
  return (rs_u16)__builtin_ia32_cvtd2mask512(condition);
}
#elif defined(__AVX__)
RS_INLINE rs_u32 rs_lane_bits(rs_int condition) {
  return (rs_u32)__builtin_ia32_movmskps256(as_float8(condition.lo)) |
         (rs_u32)__builtin_ia32_movmskps256(as_float8(condition.hi)) << 8;
}
#else
RS_INLINE rs_u32 rs_lane_bits(rs_int condition) {
  const int16 bit = condition & (int16)(1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768);
  const int8 eight = bit.lo | bit.hi;
  const int4 four = eight.lo | eight.hi;
  const int2 two = four.lo | four.hi;
  return (rs_u32)(two.x | two.y);
}
#endif
#define RS_ANY(condition) (rs_lane_bits(condition) != 0)
#elif defined(RS_LANES)
#include RS_LANES_HEADER /* the same for a vector of a C++ compiler */
#else
typedef float rs_real;
typedef rs_i32 rs_int;
typedef rs_i64 rs_sum;
#define RS_ANY(condition) (condition)
#define RS_TO_SUM(value) ((rs_i64)(value))
#define RS_TO_INT(value) ((rs_i32)(value))
#define RS_TO_REAL(value) ((float)(value))
RS_INLINE rs_i64 rs_lane_sum(rs_sum lanes) {
  return lanes;
}
#ifdef __OPENCL_C_VERSION__
#define RS_BITS_OF(real) as_int(real)
#define RS_REAL_OF(bits) as_float(bits)
#define RS_FMA(a, b, c) fma(a, b, c)
#else
RS_INLINE rs_i32 rs_bits_of(float real) {
  rs_i32 bits;
  memcpy(&bits, &real, sizeof bits);
  return bits;
}
RS_INLINE float rs_real_of(rs_i32 bits) {
  float real;
  memcpy(&real, &bits, sizeof real);
  return real;
}
#define RS_BITS_OF(real) rs_bits_of(real)
#define RS_REAL_OF(bits) rs_real_of(bits)
#define RS_FMA(a, b, c) __builtin_fmaf(a, b, c)
#endif
#endif

/* A scalar in every lane. */
#ifndef RS_REAL
#define RS_REAL(scalar) ((rs_real)(scalar))
#define RS_INT(scalar) ((rs_int)(scalar))
#define RS_SUM(scalar) ((rs_sum)(scalar))
#endif

RS_INLINE rs_real rs_abs(rs_real x) {
  return x < 0.0f ? -x : x;
}
#ifndef RS_HAS_MIN
RS_INLINE rs_real rs_min(rs_real a, rs_real b) {
  return a < b ? a : b;
}
RS_INLINE rs_real rs_max(rs_real a, rs_real b) {
  return a < b ? b : a;
}
#endif

#endif
