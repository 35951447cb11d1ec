#pragma once

#include "render/camera.h"
#include "render/results.h"
#include "render/unreamed_surface.h"

namespace reamsim {

/// What the cameras of a run look at: the glenoid where the results name one; else the tool where it was deepest, seen
/// along its own axis.
Subject make_subject(const RunResults& results, const UnreamedSurface& unreamed);

}  // namespace reamsim
