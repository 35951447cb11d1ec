// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "sim/engine/common/substep.h"
#include "sim/run/frame_stepper.h"
#include "sim/run/simulation.h"

namespace reamsim {

/// Decides the poses of a pass frame by frame: prescribed, under a given thrust, or on springs. Results do not depend
/// on batches and interruptions.
class Feed {
 public:
  virtual ~Feed() = default;
  virtual void start() = 0;
  /// Continues after a frame of this pass, or of one before it.
  virtual void resume(const SimulationState& /*from*/) {}
  /// Whether the pass ends with this frame, which has been added.
  [[nodiscard]] virtual bool has_ended(std::int64_t frame) const = 0;
  /// Decides the pose of the next frame, and adds it to the stepper's batch.
  virtual void add(std::int64_t frame) = 0;
  /// Whether the batch has to end with this frame; here because the next pose depends on the bone that this one leaves.
  [[nodiscard]] virtual bool ends_batch(std::int64_t /*frame*/) const { return true; }
  /// Takes the last row of a batch.
  virtual void take(const FrameResult& /*row*/) {}
  /// Whether this frame, which has been added, has a picture.
  [[nodiscard]] virtual bool has_picture(std::int64_t frame) const = 0;
  /// The last frame of the run, as far as it is known.
  [[nodiscard]] virtual std::int64_t last_frame() const = 0;
  virtual void warn_at_end() {}
  /// The state after the frames that are recorded.
  [[nodiscard]] virtual SimulationState state() const = 0;
};

/// A feed along planned poses, whose last frame is known.
class PlannedFeed : public Feed {
 public:
  explicit PlannedFeed(const SimulationInput& scene)
      : scene_(scene), pictures_(picture_frames(scene.scenario.render, scene.last_frame(), scene.contact)) {}
  [[nodiscard]] bool has_ended(std::int64_t frame) const override { return frame >= scene_.motion.last_frame(); }
  [[nodiscard]] bool has_picture(std::int64_t frame) const override {
    return std::ranges::binary_search(pictures_, frame);
  }
  [[nodiscard]] std::int64_t last_frame() const override { return scene_.last_frame(); }

 protected:
  [[nodiscard]] const SimulationInput& scene() const { return scene_; }

 private:
  const SimulationInput& scene_;
  std::vector<std::int64_t> pictures_;  ///< frames, ascending
};

/// A feed under a given thrust (`motion.push`). In every frame it tries feed rates on the present bone until the forces
/// balance (balance.h), and then cuts once. Feed rates whose advance in a frame is near the smallest loss that
/// single precision tells are tried over a longer time.
std::unique_ptr<Feed> thrust_feed(const SimulationInput& scene, FrameStepper& stepper, Diagnostics& report);

/// A tool on springs (`motion.compliance`). A frame has the substeps of the planned motion; in each, deflections are
/// tried on the present bone until the forces balance (balance.h), slow ones over a longer time, and the tool cuts
/// once.
std::unique_ptr<Feed> spring_feed(const SimulationInput& scene, FrameStepper& stepper, Diagnostics& report);

/// Advance of the smallest loss that single precision tells, mm.
inline double smallest_advance_mm(double voxel_mm) {
  return least_loss(voxel_mm) * voxel_mm / RS_WHOLE_FILL;
}

/// The force of a slow motion is that between two advances, in smallest losses: the first takes what earlier frames
/// left; up to the second the rounding of voxels on a face along the lattice is about 0.2 %.
inline constexpr double kFirstLosses = 8, kSecondLosses = 64;

/// A trial of a slow motion over these multiples of its time. The mean force is the difference of impulses over times.
struct SlowTrial {
  double first = 0, second = 0;
};

/// nullopt for a motion that is not slow, or that is none.
inline std::optional<SlowTrial> slow_trial(double motion_mm, double smallest_mm) {
  constexpr double kRest = 1e-3;
  if (motion_mm >= kSecondLosses * smallest_mm || motion_mm < kRest * smallest_mm) return std::nullopt;
  return SlowTrial{kFirstLosses * smallest_mm / motion_mm, kSecondLosses * smallest_mm / motion_mm};
}

}  // namespace reamsim
