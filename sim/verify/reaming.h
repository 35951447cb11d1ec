// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "sim/engine/make_engine.h"
#include "sim/run/balance.h"
#include "sim/verify/closed_forms.h"
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

/// The example of docs/physics.md, 6.
inline constexpr SteadyPlunge kExample{29, 15, 1.25, 250, 0.2, 1.8};

/// The example with one factor changed.
template <class Value>
SteadyPlunge example_with(Value SteadyPlunge::*member, std::type_identity_t<Value> value) {
  SteadyPlunge out = kExample;
  out.*member = value;
  return out;
}

/// The profile of the reamer's head.
Profile head_of(const SteadyPlunge& plunge);
/// "R 29, a 15 mm, 250 rpm, 0.2 mm/s".
std::string text_of(const SteadyPlunge& plunge);

/// A steady plunge and its discretization.
struct PlungeRun {
  SteadyPlunge plunge = {};
  double voxel_mm = 0.25;
  int frames = 32;  ///< over one voxel of feed
  int voxels = 1;   ///< of feed, with the face in contact out to its rim
  ErosionMode erosion = ErosionMode::exact;
  double tilt_deg = 0;  ///< of the axis against the lattice
  /// Bone on one side only of a plane through the axis: the side of (cos, sin) of this angle in the tool's x and y.
  /// nullopt: bone under the whole face.
  std::optional<double> half_toward_deg = {};
  std::optional<ComplianceSettings> compliance = {};
};

/// Rows over the voxels of feed with the face in contact out to its rim.
std::vector<FrameResult> steady_rows(const PlungeRun& run, const Setting& setting);

}  // namespace reamsim::verify
