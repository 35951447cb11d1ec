// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "sim/base/error.h"
#include "sim/bone/bone.h"
#include "sim/scenario/picture_frames.h"
#include "sim/scene/first_contact.h"
#include "sim/scene/load_bone.h"
#include "sim/tool/motion.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// A tool on its path.
struct Pass {
  Tool tool;
  Motion motion;
};

/// The validated input of a run.
struct SimulationInput {
  Scenario scenario;
  Bone bone;
  Tool tool;      ///< of the present pass, the first one after loading
  Motion motion;  ///< of the present pass
  std::vector<Pass> later_passes = {};
  FrameSpans contact{};  ///< expected (contact_forecast.h), for the choice of pictures
  std::vector<std::optional<FirstContact>> first_contacts = {};  ///< by pass, of plunges whose depth counts from it

  /// The first contact of the present pass.
  [[nodiscard]] std::optional<FirstContact> first_contact() const {
    const auto i = static_cast<std::size_t>(motion.pass) - 1;
    return i < first_contacts.size() ? first_contacts[i] : std::nullopt;
  }
  /// The last frame of the run.
  [[nodiscard]] std::int64_t last_frame() const {
    return later_passes.empty() ? motion.last_frame() : later_passes.back().motion.last_frame();
  }
};

/// Replaces tool and motion by those of the next pass. Returns false after the last pass.
bool begin_next_pass(SimulationInput& scene);

/// Loads bone, tool and motion of a scenario. Throws InputError with all mistakes, each at its key in the scenario
/// file. A glenoid frame that contradicts the bone is added to `frame_mistakes` instead: the scene is complete, but
/// must not run. `bones`: takes the bone from there where it is the same.
SimulationInput load_scene(const Scenario& scenario, Diagnostics& report, MistakeList& frame_mistakes,
                           BoneCache* bones = nullptr);
/// The same; throws for a wrong frame as well.
SimulationInput load_scene(const Scenario& scenario, Diagnostics& report, BoneCache* bones = nullptr);

/// Called with a pass and the fill of the bone before it.
using VisitPass = std::function<void(const FillBricks& fill, const Tool& tool, const Motion& motion)>;

/// Visits the present pass and the later ones, with the bone that those before are predicted to leave.
void for_each_predicted_pass(const SimulationInput& scene, const VisitPass& visit);

}  // namespace reamsim
