// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* x^y from correctly rounded operations; the rounding of the built-in pow() depends on the device. */
#ifndef REAMSIM_KERNELS_POWER_H
#define REAMSIM_KERNELS_POWER_H

#include "lanes.h"

/* log2(x), x > 0 and not subnormal, error below 10^-7: exponent, and the series of artanh for the mantissa in 2^(-1/2)
 * .. 2^(1/2). */
RS_INLINE rs_real rs_log2(rs_real x) {
  const rs_real one = RS_REAL(1.0f);
  const rs_int bits = RS_BITS_OF(x), zero = RS_INT(0), single = RS_INT(1);
  const rs_real whole = RS_REAL_OF((bits & 0x007fffff) | 0x3f800000); /* 1 .. 2 */
  const rs_real mantissa = whole > 1.41421356f ? whole * 0.5f : whole;
  const rs_int exponent = (bits >> 23) - 127 + (whole > 1.41421356f ? single : zero);
  const rs_real t = (mantissa - one) / (mantissa + one), t2 = t * t;
  const rs_real series =
      t * (2.88539008f + t2 * (0.961796694f + t2 * (0.577078016f + t2 * (0.412198583f + t2 * 0.320598898f))));
  return RS_TO_REAL(exponent) + series;
}

/* 2^x, |x| < 126, relative error below 2·10^-7: exponent, and the series of exp for the remainder. */
RS_INLINE rs_real rs_exp2(rs_real x) {
  const rs_real whole = RS_FLOOR(x + 0.5f), rest = (x - whole) * 0.693147181f;
  const rs_real series =
      1.0f +
      rest *
          (1.0f +
           rest * (0.5f + rest * (0.166666667f +
                                  rest * (0.0416666667f + rest * (0.00833333333f +
                                                                  rest * (0.00138888889f + rest * 0.000198412698f))))));
  return series * RS_REAL_OF((RS_TO_INT(whole) + 127) << 23);
}

/* x^y, relative error about 10^-6, for x > 0 and |y·log2(x)| < 126. */
RS_INLINE rs_real rs_power(rs_real x, float y) {
  return rs_exp2(y * rs_log2(x));
}

#endif
