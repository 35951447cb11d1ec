#pragma once

#include "sim/base/mistake_list.h"
#include "sim/base/report.h"
#include "sim/bone/bone.h"
#include "sim/motion/motion.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// Everything that a run needs, loaded and validated.
struct ReamingScene {
  Scenario scenario;
  Bone bone;
  Tool tool;
  Motion motion;
};

/// Loads bone, tool and motion of a scenario. Throws InputError with every mistake that is found in them, each at its
/// key in the scenario file. A glenoid frame that contradicts the bone is put on `frame_mistakes` instead: the scene
/// is complete, but must not be run.
ReamingScene load_scene(const Scenario& scenario, Report& report, MistakeList& frame_mistakes);
/// The same, with a wrong frame thrown as well.
ReamingScene load_scene(const Scenario& scenario, Report& report);

}  // namespace reamsim
