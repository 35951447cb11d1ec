#pragma once

#include <string>

#include "render/pictures/captions.h"
#include "render/pictures/finished_run.h"
#include "render/pictures/results.h"
#include "render/pictures/studio.h"

namespace reamsim::test {

/// A run's folder, opened for photographs; single frames' forces.
struct OpenedRun {
  OpenedRun(const std::string& dir, const RenderSettings& settings)
      : run(dir), view(run.planned(), settings), studio(view), captions(run.results().log, 0, true) {}

  [[nodiscard]] Camera camera(const std::string& name) const {
    return view.camera(name, view.settings().width_px, view.settings().height_px);
  }
  [[nodiscard]] const ForceRow& last_row() const { return captions.log().rows.back(); }

  FinishedRun run;
  RunView view;
  Studio studio;
  Captions captions;
};

}  // namespace reamsim::test
