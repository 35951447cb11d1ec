// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/study/study.h"

namespace reamsim {

/// Points of the open unit cube: points[i][d], `n` of them, or with saltelli n·(dimensions + 2).
///
/// sobol: the sequence of Sobol with the direction numbers of Joe and Kuo (2008), randomized by a digital shift;
/// latin_hypercube: one point in each of n equal intervals of every dimension (McKay et al. 1979); monte_carlo:
/// independent points; saltelli: the matrices A, B and A with one column of B, for every dimension (Saltelli et al.
/// 2010), from a sobol sequence of twice the dimensions; rows i·(dimensions + 2) … of the result are A, B, AB₁, AB₂, …
/// of point i.
///
/// The same arguments give the same points on every machine. With sobol, monte_carlo and saltelli, a larger n only adds
/// points. Throws InputError for more dimensions than the sequence has.
std::vector<std::vector<double>> unit_points(SampleMethod method, int n, int dimensions, std::uint64_t seed);

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
