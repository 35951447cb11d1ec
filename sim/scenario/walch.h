#pragma once

#include "sim/scenario/scenario.h"

namespace reamsim {

/// Puts the values of its Walch type in the place of a glenoid phantom's defaults; docs/physics.md says where each
/// comes from. Leaves what the type does not speak of, and everything with `walch: none`, as it is.
void take_walch_defaults(PhantomSettings& phantom);

}  // namespace reamsim
