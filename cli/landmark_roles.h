// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/scenario/choices.h"
#include "sim/scenario/markups.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// Landmarks of a scapula for a first scenario, LPS, mm.
struct Landmarks {
  std::optional<Vec3> center;
  GlenoidSettings glenoid;         ///< landmarks where all three are there, else the superior direction; and the rim
  std::vector<std::string> found;  ///< for the user: which point was understood as what, and which were not used
};

/// The landmarks of markups files, by their labels: "Glenoid centre", "TS", "rim-3", in any case, with the number that
/// Slicer adds. `given`: "ROLE=LABEL", which come first. Labels that name the other side of the body are left out.
/// Throws InputError: a file that cannot be read, a role or a label that does not exist, two points for one role, no
/// point that is understood, a superior point at the centre.
Landmarks find_landmarks(const std::vector<std::string>& files, const std::vector<std::string>& given, BodySide side);

}  // namespace reamsim
