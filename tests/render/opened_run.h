// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "render/pictures/renderer.h"

namespace reamsim::test {

/// A run's folder, opened for rendering; forces as in its log.
struct OpenedRun {
  OpenedRun(const std::string& dir, const RenderSettings& settings)
      : run(dir), view(run, settings), renderer(view), captions(run.log(), true) {}

  [[nodiscard]] Camera camera(const std::string& name) const {
    return view.camera(name, view.page().view_width_px, view.page().height_px);
  }
  [[nodiscard]] const ForceRow& last_row() const { return run.log().rows.back(); }

  RunData run;
  RunView view;
  Renderer renderer;
  Captions captions;
};

}  // namespace reamsim::test
