#pragma once

#include "render/gl/camera.h"
#include "render/pictures/run_plan.h"
#include "render/surface/unreamed_surface.h"

namespace reamsim {

/// What the cameras of a run look at: the glenoid where the plan names one; else the tool where it is deepest, seen
/// along its own axis.
Subject make_subject(const RunPlan& plan, const ToolPose& deepest, const UnreamedSurface& unreamed);

}  // namespace reamsim
