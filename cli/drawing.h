#pragma once

#include <memory>
#include <string>

#include "render/photographer.h"
#include "render/pictures/planned_run.h"
#include "render/pictures/snapshot_feed.h"
#include "sim/run/simulation.h"

namespace reamsim {

/// The drawing of a run, on threads of its own beside the simulation.
struct Drawing {
  explicit Drawing(RunPlan plan) : run(std::move(plan)) {}

  PlannedRun run;
  SnapshotFeed snapshots;                      ///< to be told which frames are written
  std::unique_ptr<Photographer> photographer;  ///< none where no pictures are wanted
};

/// Begins it where the scenario wants anything drawn; else null. DIR/snapshots/tool.stl is there already. Of `scene`,
/// which outlives the drawing, it reads what a simulation leaves alone.
std::unique_ptr<Drawing> begin_drawing(const ReamingScene& scene, const std::string& dir);

}  // namespace reamsim
