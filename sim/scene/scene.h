#pragma once

#include "sim/base/mistake_list.h"
#include "sim/base/report.h"
#include "sim/bone/bone.h"
#include "sim/motion/motion.h"
#include "sim/scene/first_contact.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// The validated input of a run.
struct ReamingScene {
  Scenario scenario;
  Bone bone;
  Tool tool;
  Motion motion;
  std::optional<FirstContact> first_contact{};  ///< of a plunge whose depth counts from it
};

/// Loads bone, tool and motion of a scenario. Throws InputError with all mistakes, each at its key in the scenario
/// file. A glenoid frame that contradicts the bone is added to `frame_mistakes` instead: the scene is complete, but
/// must not run.
ReamingScene load_scene(const Scenario& scenario, Report& report, MistakeList& frame_mistakes);
/// The same; throws for a wrong frame as well.
ReamingScene load_scene(const Scenario& scenario, Report& report);

}  // namespace reamsim
