#pragma once

#include "render/gl/camera.h"
#include "render/pictures/run_data.h"
#include "render/surface/solid_field.h"

namespace reamsim {

/// What the cameras of a run look at: the glenoid where it is known; else the tool where it is deepest, seen along its
/// own axis. `bone`: the unreamed surface, voxel index space.
ViewTarget make_view_target(const RunInputs& run, const ToolPose& deepest, const IsoSurface& bone);

}  // namespace reamsim
