// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <vector>

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

}  // namespace reamsim
