// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

namespace reamsim::test {

/// An ASCII STL of a cube with corners 0 and `side`, without its last `missing` of 12 triangles.
std::string cube_stl(double side, int missing = 0);

/// The bytes of a binary STL of `facets` triangles in a row, whose header claims `claimed` of them.
std::string binary_stl(unsigned facets, unsigned claimed);

/// An NRRD of 20³ int16 voxels of 1 mm from the origin: air (−1000 HU) with a block of bone (1000 HU) at 5…14.
std::string block_nrrd();

/// The same scan as NIfTI (single file).
std::string block_nifti();

/// Only the header of an NRRD or NIfTI that claims this many voxels along each axis.
std::string nrrd_header(long side);
std::string nifti_header(short side);

}  // namespace reamsim::test
