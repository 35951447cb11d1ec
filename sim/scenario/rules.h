#pragma once

#include "sim/scenario/reader.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// The rules that take more than one key: which go together, what is needed because of another, geometry that cannot
/// be. Each rule that is broken puts its mistake on the list, at the key that is at fault; a rule of keys that have a
/// mistake already is not looked at.
void check_rules(const Scenario& scenario, const KeyLocations& locations, MistakeList& mistakes);

/// Those of the user's cameras: names that files can have, each once; a direction of view, and an up across it.
/// Throws InputError.
void check_cameras(const RenderSettings& render, const KeyLocations& locations);

/// Those of bone.glenoid.rim_mm: of a joint face's size, not on a line, in order round it. Throws
/// InputError.
void check_rim(const std::vector<Vec3>& rim_mm, const KeyLocations& locations);

}  // namespace reamsim
