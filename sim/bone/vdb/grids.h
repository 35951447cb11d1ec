// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <openvdb/openvdb.h>

#include "sim/isolation/child_result.h"

namespace reamsim {

// An empty grid with the identity as its transform. Defined in one file, because OpenVDB's create() adds half a minute
// to the compilation of each file that calls it.
openvdb::FloatGrid::Ptr make_float_grid(float background);
openvdb::BoolGrid::Ptr make_bool_grid(bool background);

// Grids as plain arrays, which child processes hand back: values of leaves and tiles, the affine transform, and the
// metadata that are numbers or texts.

/// Writes a grid, and empties its leaves on the way.
void put_grid(ResultWriter& out, openvdb::FloatGrid& grid);

/// Throws InputError where the arrays are inconsistent.
openvdb::FloatGrid::Ptr take_grid(ResultReader& in);

}  // namespace reamsim
