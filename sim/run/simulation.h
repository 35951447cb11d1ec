#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "sim/base/mistake_list.h"
#include "sim/base/report.h"
#include "sim/bone/bone.h"
#include "sim/motion/motion.h"
#include "sim/record/frame_sink.h"
#include "sim/run/engine.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// What the caller of a run may watch and steer.
struct RunControl {
  /// Called after each batch with (frames done, frames in all).
  std::function<void(std::int64_t, std::int64_t)> progress = [](std::int64_t, std::int64_t) {};
  /// Asked after each batch; true ends the run with Interrupted.
  std::function<bool()> stop = [] { return false; };
  /// The user has been told already that the tool will never touch the bone (contact_forecast.h).
  bool foretold_no_contact = false;
};

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

/// make_engine() for the scene, whose mistakes stand at their keys. Throws InputError, RunError.
std::unique_ptr<Engine> load_engine(const ReamingScene& scene);

/// Runs the motion: per substep broad phase → detect → cut, per batch record. `scene.bone` is reamed; rows, snapshots
/// and timings go to `sink`. Warns when the tool never touches, starts inside bone, or cuts without spin.
void simulate(ReamingScene& scene, Engine& engine, FrameSink& sink, const RunControl& control, Report& report);

/// Frames whose state is kept for pictures: 0, every n-th and the last, which is `last`. Ascending.
std::vector<std::int64_t> picture_frames(const RenderSettings& settings, std::int64_t last);

/// What a run will cost, from the motion alone.
struct RunCost {
  std::int64_t frames = 0;
  std::int64_t substeps = 0;
};
RunCost estimate_cost(const ReamingScene& scene);

}  // namespace reamsim
