// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <span>

#include "sim/engine/make_engine.h"
#include "sim/run/thrust_balance.h"
#include "sim/verify/scene.h"

namespace reamsim::verify {

/// Makes the engine of a scene, as make_engine() does.
using EngineMaker = std::function<std::unique_ptr<Engine>(const Scenario&, const BoneView&, const Tool&)>;

struct Setting {
  bool quick = true;
  std::string device = "auto";
  /// Tests of the suite put an engine with a wrong constant here.
  EngineMaker engine = make_engine;
  std::function<void(const std::string&)> progress = [](const std::string&) {};
  /// Called before each case of the suite, with the fraction of the expected time that lies behind, and at the end.
  std::function<void(double, const std::string&)> part = [](double, const std::string&) {};
  std::function<bool()> stop = [] { return false; };
};

/// The result of reaming a scene.
struct Reamed {
  std::vector<FrameResult> rows;  ///< rows[k] is frame k
  Bone bone;                      ///< after reaming
  FeedState feed = {};            ///< under thrust
  SpringState springs = {};       ///< after a run of a tool on springs

  [[nodiscard]] double removed_mm3() const;
  /// Rows of the frames after `frame`.
  [[nodiscard]] std::span<const FrameResult> after(std::size_t frame) const {
    return std::span(rows).subspan(frame + 1);
  }
};

/// Reams the scene with the program's main loop. Throws InputError (no such device), RunError, Interrupted.
Reamed ream(SimulationInput scene, const Setting& setting);

struct MeanLoads {
  Vec3 force_n = Vec3::Zero();
  Vec3 torque_nmm = Vec3::Zero();
  double axial_force_n = 0;
  double spin_torque_nmm = 0;
  double removed_mm3 = 0;  ///< sum, not mean
};
/// Means over rows.
MeanLoads mean_loads(std::span<const FrameResult> rows);
/// Standard deviation of the rows' spin torque over its mean.
double torque_ripple(std::span<const FrameResult> rows);
/// Root mean square.
double rms(std::span<const double> values);

}  // namespace reamsim::verify
