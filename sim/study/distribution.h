// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/study/study.h"

namespace reamsim {

/// A sample of a distribution of numbers (normal, lognormal, uniform), from u in (0, 1): the inverse of its cumulative
/// distribution.
double sample_number(const Distribution& distribution, double u);

/// The quantile of the standard normal distribution.
double normal_quantile(double u);

/// `direction`, of unit length, rotated about the axis (a·e₁ + b·e₂) by its length in degrees, where e₁ and e₂ are unit
/// vectors across the direction: e₁ along direction × x, or direction × y where the direction
/// lies no nearer to y than to x.
Vec3 tilted(const Vec3& direction, double a_deg, double b_deg);

}  // namespace reamsim
