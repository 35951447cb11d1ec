#pragma once

#include "sim/base/mistake_list.h"
#include "sim/base/report.h"
#include "sim/bone/bone.h"
#include "sim/motion/motion.h"
#include "sim/scenario/picture_frames.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// The validated input of a run.
struct ReamingScene {
  Scenario scenario;
  Bone bone;
  Tool tool;
  Motion motion;
  std::optional<FrameSpan> contact{};  ///< expected (sim/predict), for the choice of pictures; none: not known
};

/// Loads bone, tool and motion of a scenario. Throws InputError with all mistakes, each at its key in the scenario
/// file. A glenoid frame that contradicts the bone is added to `frame_mistakes` instead: the scene is complete, but
/// must not run.
ReamingScene load_scene(const Scenario& scenario, Report& report, MistakeList& frame_mistakes);
/// The same; throws for a wrong frame as well.
ReamingScene load_scene(const Scenario& scenario, Report& report);

}  // namespace reamsim
