#pragma once

#include <string>

#include "sim/bone/vdb/bone_vdb.h"

namespace reamsim {

/// The glenoid frame in the text of `bone_from_glenoid`: 16 numbers, 4 × 4, row by row; nullopt for an empty text.
/// Throws InputError when they are no rigid transform.
std::optional<GlenoidFrame> parse_stored_glenoid(const std::string& path, const std::string& text);

/// Glenoid centre, trigonum spinae and inferior angle in 9 numbers; nullopt for an empty text. Throws InputError.
std::optional<LandmarkSettings> parse_stored_landmarks(const std::string& path, const std::string& text);

/// The text itself; InputError unless it is left, right or empty.
BodySide checked_stored_side(const std::string& path, const std::string& text);

}  // namespace reamsim
