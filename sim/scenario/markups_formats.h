// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "sim/scenario/markups.h"

namespace reamsim {

inline constexpr const char* kExpectedMarkups =
    "expected a markups file of 3D Slicer: .mrk.json or .fcsv, as its module Markups saves it";

/// The text of an .fcsv. Versions of Slicer 4 and 5 name their coordinate system: 0 or RAS, 1 or LPS; without it, and
/// in files of Slicer 3, the points are RAS, as Slicer reads them. Throws InputError with line.
Markups parse_fcsv(const std::string& text, const std::string& path);

/// The text of an .mrk.json (schema 1.0.0 to 1.0.4). Without coordinateSystem it is LPS, without coordinateUnits mm, as
/// the schema says. Throws InputError.
Markups parse_markups_json(const std::string& text, const std::string& path);

}  // namespace reamsim
