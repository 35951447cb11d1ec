// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* What the machine can do at most, for the benchmark: fused multiply-adds in registers, and a copy of memory. */

/* `rounds` times eight independent chains of fused multiply-adds of sixteen lanes: 256 operations. */
__kernel void fused_multiply_adds(__global float16* out, const int rounds) {
  const float16 scale = 0.999f, shift = 0.001f;
  float16 a = (float)get_global_id(0), b = a + 1.0f, c = a + 2.0f, d = a + 3.0f;
  float16 e = a + 4.0f, f = a + 5.0f, g = a + 6.0f, h = a + 7.0f;
  for (int i = 0; i < rounds; ++i) {
    a = fma(a, scale, shift);
    b = fma(b, scale, shift);
    c = fma(c, scale, shift);
    d = fma(d, scale, shift);
    e = fma(e, scale, shift);
    f = fma(f, scale, shift);
    g = fma(g, scale, shift);
    h = fma(h, scale, shift);
  }
  out[get_global_id(0)] = a + b + c + d + e + f + g + h;
}

/* Copies `count` vectors in each work-item. */
__kernel void copy_memory(__global const float16* from, __global float16* to, const int count) {
  const size_t first = (size_t)count * get_global_id(0);
  for (int i = 0; i < count; ++i) to[first + i] = from[first + i];
}
