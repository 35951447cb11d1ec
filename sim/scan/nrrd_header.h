// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/base/geometry.h"

namespace reamsim::ct {

/// What ITK leaves out of the header of an NRRD, or converts by rules that differ between its versions.
struct NrrdHeader {
  std::string space = {};             ///< letters and digits in lower case. ITK names the space into which it converted
  std::vector<Vec3> directions = {};  ///< of the axes that have one, in the space and its units
  Vec3 to_mm = Vec3::Ones();          ///< millimetres in the length unit of each axis of the space
  std::string unknown_unit = {};      ///< the first that is no known length unit, taken as mm; empty: none
};

/// Reads the header up to its end, the first blank line.
NrrdHeader read_nrrd_header(const std::string& path);

}  // namespace reamsim::ct
