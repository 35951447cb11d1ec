// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <tuple>
#include <vector>

#include "sim/base/stopwatch.h"
#include "sim/engine/common/engine.h"
#include "sim/engine/common/substep.h"
#include "sim/record/results.h"
#include "sim/scene/scene.h"

namespace reamsim {

struct FrameMotion {
  std::int64_t frame = 0;
  ToolPose before;  ///< at the start of the frame
  ToolPose pose;    ///< at its end
  double duration_s = 1e-3;
  double time_s = 0;                       ///< at its end
  std::optional<PushResult> push = {};     ///< of a frame that a hand decided
  std::optional<Vec3> deflection_mm = {};  ///< of a tool on springs, T
};

/// The motion of a frame along planned poses.
inline FrameMotion planned_motion(const Motion& motion, std::int64_t frame) {
  return {.frame = frame,
          .before = motion.pose_of(std::max(frame - 1, motion.first_frame)),
          .pose = motion.pose_of(frame),
          .duration_s = motion.frame_s(),
          .time_s = static_cast<double>(frame) * motion.frame_s()};
}

/// A frame with substeps in the engine's batch.
struct PendingFrame : FrameMotion {
  int pass = 1;
  int substeps = 1;
  std::vector<std::pair<std::size_t, Substep>>
      cut;  ///< (index in the batch, substep) of those that passed the broad phase
  double broad_phase_s = 0;
};

/// Force and torque of the bone in the sums of a substep, in their frame.
inline Vec3 force_of(const SubstepSums& sums) {
  return Eigen::Map<const Eigen::Matrix<rs_i64, 3, 1>>(sums.force).cast<double>() / RS_FORCE_SCALE;
}
inline Vec3 torque_of(const SubstepSums& sums) {
  return Eigen::Map<const Eigen::Matrix<rs_i64, 3, 1>>(sums.torque).cast<double>() / RS_TORQUE_SCALE;
}

/// Work on the bone in a substep, mJ.
inline double work_of(const Substep& substep, const Vec3& force, const Vec3& torque) {
  return -(torque.dot(substep.angular_velocity) + force.dot(substep.origin_velocity_mm_s)) * substep.duration_s;
}

/// The energy balance of a run so far, and where it began to cut.
struct EnergySums {
  double work_mj = 0;
  double floor_mj = 0;
  double cut_mj = 0;
  std::optional<Vec3> first_contact_mm = {};  ///< of the tool's origin, B

  static auto fields(auto& self) { return std::tie(self.work_mj, self.floor_mj, self.cut_mj, self.first_contact_mm); }
};

/// Converts the integer sums of the substeps to the rows of forces.csv, and keeps the energy balance: the work on the
/// bone, −Σ(T·ω + F·v)·Δt + E_floor, against the cutting energy, which is summed independently (docs/physics.md, 5).
class EnergyBalance {
 public:
  /// `sums_rotate`: sums are in the shell's frame, which rotates with resolved cutting edges (law per_point).
  /// `contact`: of a plunge that counts from its first contact, which has been found before the run.
  EnergyBalance(double voxel_mm3, bool sums_rotate, const std::optional<FirstContact>& contact)
      : voxel_mm3_(voxel_mm3), sums_rotate_(sums_rotate), contact_(contact) {}

  FrameResult close(const PendingFrame& frame, const std::vector<SubstepSums>& sums);

  /// (work + E_floor − cut)/cut; 0 before contact.
  [[nodiscard]] double balance() const {
    return run.cut_mj > 0 ? (run.work_mj + run.floor_mj - run.cut_mj) / run.cut_mj : 0;
  }

  EnergySums run;

 private:
  double voxel_mm3_;
  bool sums_rotate_;
  std::optional<FirstContact> contact_;
};

/// The box of the voxels with bone, B.
Aabb bone_box(const Voxmap& voxmap);

/// What a simulation has to know to go on after a frame, besides the fill of the bone and the hand that pushes.
struct StepState {
  std::int64_t frame = 0;  ///< the last one that is recorded
  EnergySums energy;
  bool touched = false;  ///< the tool has been in contact
  bool warned_of_no_spin = false;

  static auto fields(auto& self) { return std::tie(self.frame, self.energy, self.touched, self.warned_of_no_spin); }
};

/// Moves the tool of the present pass frame by frame: broad phase → enqueue for the frames of a batch, collect → record
/// for all of them. The caller decides the poses. Results do not depend on batches.
class FrameStepper {
 public:
  /// All must outlive the stepper. The engine has the fill of `scene.bone`, which is reamed; `sink` receives rows,
  /// snapshots and timings.
  FrameStepper(SimulationInput& scene, Engine& engine, FrameSink& sink, Diagnostics& report);

  /// The first frame of a pass. Where voxels are clipped, bone in the tool's first pose is removed without force.
  void start(const FrameMotion& rest);
  /// Adds a frame to the batch. `window`: of smooth motion that it belongs to; nullptr: none.
  void add(const FrameMotion& motion, const std::shared_ptr<const MotionWindow>& window = nullptr);
  /// Adds part `i` of `parts` of a frame that is decided part by part, each of a single substep and the same time, to
  /// an empty batch, and cuts at once. Returns the sums of the part.
  SubstepSums add_part(const FrameMotion& part, int i, int parts);
  /// The row of the frame in the batch will have this deflection of the tool, in T.
  void set_deflection(const Vec3& mm) { pending_.back().deflection_mm = mm; }
  /// Waits for the frames of the batch, and takes the sums of their substeps and the removed voxels.
  void collect();
  /// Ends the batch, which has been collected: fill of the bone, rows, and removed voxels.
  void record();
  void finish_batch() {
    collect();
    record();
  }
  /// Whether the batch has `most` frames, or takes so long that a run would not stop soon when it is asked to.
  [[nodiscard]] bool is_full(int most) const;

  /// Gives the fill of the bone to the sink, as a snapshot of `frame`.
  void snapshot(std::int64_t frame);
  void read_fill() {
    if (!cut_since_read_) return;
    engine_.read_fill(*scene_.bone.voxmap, scene_.bone.fill);
    cut_since_read_ = false;
  }

  /// The sums of motions of a single substep, each from the present fill, which they leave as it is. Only for the
  /// engine `exact`; all of the batch must have been cut.
  std::vector<SubstepSums> evaluate(const std::vector<FrameMotion>& motions);

  /// The row that add() and finish_batch() would record of a motion, which leaves bone and sums as they are. Only for
  /// the engine `exact`, with an empty batch.
  FrameResult peek(const FrameMotion& motion);

  /// The arguments of a frame that has a single substep; nullopt for others.
  [[nodiscard]] std::optional<SubstepArgs> single_args(const FrameMotion& motion) const;
  [[nodiscard]] const Aabb& tool_box() const { return tool_box_; }
  /// Whether the engine can use windows of smooth motion.
  [[nodiscard]] bool can_use_windows() const { return exact_ && !resolved_; }

  [[nodiscard]] const FrameResult& last() const { return last_; }

  [[nodiscard]] StepState state() const;
  void resume(const StepState& from);

  [[nodiscard]] std::string name_of_pass() const;

 private:
  [[nodiscard]] PendingFrame pending_of(const FrameMotion& motion) const {
    return {motion, scene_.motion.pass, 1, {}, 0};
  }
  PendingFrame& begin_frame(const FrameMotion& motion);
  void enqueue_motion(const FrameMotion& motion, int substeps, const std::shared_ptr<const MotionWindow>& window,
                      PendingFrame& pending);
  std::optional<Aabb> broad_phase(const Substep& substep, PendingFrame& pending) const;
  [[nodiscard]] SubstepArgs args_of(const Substep& substep, const Aabb& voi) const {
    return make_args(substep, voi, scene_.tool.shell, scene_.bone.voxmap->grid, scene_.scenario.cutting, resolved_);
  }
  void enqueue(const Substep& substep, const SubstepArgs& args, std::shared_ptr<const MotionWindow> window,
               PendingFrame& pending);
  void clear_batch();
  void warn_of(const FrameResult& result);

  SimulationInput& scene_;
  Engine& engine_;
  FrameSink& sink_;
  Diagnostics& report_;
  Aabb tool_box_;
  Aabb bone_box_;
  EnergyBalance energy_;
  bool resolved_;
  bool exact_;
  double max_step_mm_;
  std::vector<PendingFrame> pending_;
  Batch batch_;                  ///< of the pending frames
  std::size_t enqueued_ = 0;     ///< substeps of these frames
  bool cut_since_read_ = false;  ///< the fill of the engine differs from that of the bone
  bool uncut_ = false;           ///< some of them wait in the engine
  RemovedFrames removed_;
  Stopwatch batch_watch_;    ///< since the first frame of the batch was added
  double frame_wall_s_ = 0;  ///< of the last batch
  StepState state_;          ///< without the energy sums
  FrameResult last_;
};

/// Whether the spin moves the cutting surface. A surface of revolution that clips voxels is its own envelope.
bool is_moved_by_spin(const Scenario& scenario, const Tool& tool);

}  // namespace reamsim
