// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <cmath>
#include <utility>

#include "sim/api/state_parts.h"
#include "sim/engine/common/substep.h"
#include "sim/run/simulation.h"
#include "sim/scenario/parse.h"
#include "sim/scenario/paths.h"
#include "sim/tool/motion.h"

namespace reamsim {

namespace {

std::array<double, 3> array_of(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

Pose pose_of(const ToolPose& pose) {
  const Quat& q = pose.orientation;
  return {array_of(pose.position_mm), {q.w(), q.x(), q.y(), q.z()}, pose.spin_rpm, pose.spin_angle_rad};
}

StepResult result_of(const FrameResult& r) {
  return {.frame = r.frame,
          .time_s = r.time_s,
          .force_n = array_of(r.force_n),
          .torque_nmm = array_of(r.torque_nmm),
          .axial_force_n = r.axial_force_n,
          .spin_torque_nmm = r.spin_torque_nmm,
          .depth_mm = r.depth_mm,
          .contacts = r.contacts,
          .removed_mm3 = r.removed_mm3,
          .energy_mj = r.energy_mj,
          .floor_energy_mj = r.floor_energy_mj,
          .balance = r.balance,
          .pose = pose_of(r.pose)};
}

/// value(grade, fill) of the voxels with bone before the first step, 0 elsewhere.
template <class Value>
Volume volume_of(const BoneView& bone, const Value& value) {
  const VoxelGrid& grid = bone.voxmap.grid;
  Volume out{{grid.dims.x(), grid.dims.y(), grid.dims.z()},
             grid.voxel_mm,
             array_of(grid.origin_mm),
             std::vector<float>(static_cast<std::size_t>(grid.size()))};
  for_each_bone_voxel(bone, [&](const Vec3i& voxel, std::uint8_t grade, std::uint16_t fill) {
    out.values[static_cast<std::size_t>(grid.index(voxel))] = value(grade, fill);
  });
  return out;
}

constexpr const char* kFailed = "an earlier step failed: make a new simulation";

}  // namespace

struct Simulation::Core {
  struct Rows final : FrameSink {
    void frame(const FrameResult& result, const FrameTimes&) override { rows.push_back(result_of(result)); }
    std::vector<StepResult> rows;
  };

  explicit Core(const std::string& path, const std::vector<std::string>& set)
      : scene(load(parse_scenario(path, set), report)),
        engine(load_engine(scene)),
        stepper(scene, *engine, rows, report),
        identity(identity_of(scene.bone)) {}

  static SimulationInput load(const Scenario& scenario, Diagnostics& report) {
    SimulationInput out = load_scene(scenario, report);
    if (!out.later_passes.empty()) throw InputError("motion.passes: a simulation has one tool; use motion.plunge");
    if (scenario.motion.compliance)
      report.warn("motion.compliance: without springs here, the tool is where step() puts it");
    if (scenario.motion.push)
      report.warn("motion.push: without a hand here, planned_poses() are those of a push that meets no bone");
    return out;
  }

  /// The pose after `before`, which is nullopt for the first one.
  [[nodiscard]] ToolPose checked(const Pose& pose, const std::optional<ToolPose>& before, double dt) const {
    ToolPose out;
    const auto& q = pose.quaternion;
    out.position_mm = Vec3(pose.position_mm.data());
    out.orientation = Quat(q[0], q[1], q[2], q[3]);
    out.spin_rpm = pose.spin_rpm;
    constexpr double kUnit = 1e-3;
    if (!out.position_mm.allFinite() || !std::isfinite(pose.spin_rpm))
      throw BadInput("pose: a position or spindle speed is not finite");
    if (!(std::abs(out.orientation.norm() - 1) <= kUnit)) throw BadInput("pose: the quaternion is no rotation");
    const double since = before ? before->spin_angle_rad + spin_rad(before->spin_rpm, pose.spin_rpm, dt) : 0;
    out.spin_angle_rad = pose.spin_angle_rad.value_or(since);
    if (!std::isfinite(out.spin_angle_rad)) throw BadInput("pose: the spin angle is not finite");
    return out;
  }

  [[nodiscard]] FrameMotion motion_to(const Pose& pose, std::optional<double> dt) const {
    if (!progress.pose) throw BadInput("call start() before step() and peek()");
    const double duration_s = dt.value_or(scene.motion.frame_s());
    if (!(duration_s > 0) || !std::isfinite(duration_s)) throw BadInput("dt: a time above 0 s is needed");
    const std::int64_t frame = stepper.state().frame + 1;
    // Equal steps have the times of a run, without accumulated rounding.
    const bool even = !dt && !progress.uneven;
    return {.frame = frame,
            .before = *progress.pose,
            .pose = checked(pose, progress.pose, duration_s),
            .duration_s = duration_s,
            .time_s = even ? static_cast<double>(frame) * duration_s : progress.time_s + duration_s};
  }

  [[nodiscard]] std::vector<FrameMotion> motions_to(std::span<const Pose> poses) const {
    std::vector<FrameMotion> out{motion_to(poses.front(), {})};
    for (const Pose& pose : poses.subspan(1)) {
      FrameMotion next = out.back();
      next.before = next.pose;
      next.pose = checked(pose, next.before, next.duration_s);
      ++next.frame;
      next.time_s = progress.uneven ? next.time_s + next.duration_s : static_cast<double>(next.frame) * next.duration_s;
      out.push_back(next);
    }
    return out;
  }

  [[nodiscard]] FrameMotion first_motion(const Pose& pose) const {
    const ToolPose first = checked(pose, std::nullopt, 0);
    return {.before = first, .pose = first, .duration_s = scene.motion.frame_s()};
  }

  /// Calls work(), which computes. A failure in it leaves bone and sums of different steps.
  template <class Work>
  void compute(const Work& work) {
    if (std::exchange(failed, true)) throw RunFailure(kFailed);
    rows.rows.clear();
    work();
    failed = false;
  }

  /// Takes the rows since compute() began; the last one is that of `last`.
  std::vector<StepResult> take(const FrameMotion& last) {
    progress.pose = last.pose;
    progress.time_s = last.time_s;
    std::vector<StepResult> out = std::exchange(rows.rows, {});
    for (const StepResult& row : out) progress.removed_mm3 += row.removed_mm3;
    return out;
  }

  std::vector<StepResult> start(const FrameMotion& rest) {
    compute([&] { stepper.start(rest); });
    return take(rest);
  }

  /// Takes steps until the last one or, after a batch, stop().
  std::vector<StepResult> run(const std::vector<FrameMotion>& motions, const std::function<bool()>& stop) {
    const std::int64_t first = motions.front().frame;
    const auto args_of = [&](std::int64_t frame) -> std::optional<SubstepArgs> {
      const std::int64_t i = frame - first;
      if (i < 0 || i >= std::ssize(motions)) return std::nullopt;
      return stepper.single_args(motions[static_cast<std::size_t>(i)]);
    };
    MotionWindows windows(args_of, motions.back().frame, stepper.tool_box());
    const bool windowed = stepper.can_use_windows();
    const FrameMotion* last = nullptr;
    compute([&] {
      for (const FrameMotion& motion : motions) {
        stepper.add(motion, windowed ? windows.of(motion.frame) : nullptr);
        last = &motion;
        if (!stepper.is_full(scene.scenario.engine.batch_frames)) continue;
        stepper.finish_batch();
        if (stop && stop()) break;
      }
      stepper.finish_batch();
    });
    return take(*last);
  }

  Diagnostics report;
  SimulationInput scene;
  std::unique_ptr<Engine> engine;
  Rows rows;
  FrameStepper stepper;
  BoneIdentity identity;
  Progress progress;    ///< but for `step`, which the stepper has
  bool failed = false;  ///< a step did not end
};

Simulation::Simulation(const std::string& scenario, const std::vector<std::string>& set)
    : core_(guarded([&] { return std::make_unique<Core>(shipped_or_path(scenario, ShippedKind::scenario), set); })) {}
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;
Simulation::~Simulation() = default;

double Simulation::frame_s() const {
  return core_->scene.motion.frame_s();
}

std::vector<Pose> Simulation::planned_poses() const {
  return guarded([&] {
    std::vector<Pose> out;
    for (const ToolPose& pose : core_->scene.motion.poses.all()) out.push_back(pose_of(pose));
    return out;
  });
}

std::vector<std::string> Simulation::warnings() const {
  return core_->report.warnings;
}

StepResult Simulation::start(const Pose& pose) {
  return guarded([&] {
    if (core_->progress.pose) throw BadInput("start() has been called; restore() an earlier state");
    return core_->start(core_->first_motion(pose)).back();
  });
}

StepResult Simulation::step(const Pose& pose, std::optional<double> dt) {
  return guarded([&] {
    const FrameMotion motion = core_->motion_to(pose, dt);
    core_->compute([&] {
      core_->stepper.add(motion);
      core_->stepper.finish_batch();
    });
    core_->progress.uneven = core_->progress.uneven || dt.has_value();
    return core_->take(motion).back();
  });
}

std::vector<StepResult> Simulation::run(std::span<const Pose> poses, const std::function<bool()>& stop) {
  return guarded([&] {
    std::vector<StepResult> out;
    if (poses.empty()) return out;
    Core& core = *core_;
    if (!core.progress.pose) {
      const FrameMotion rest = core.first_motion(poses.front());
      std::optional<ToolPose> before = rest.pose;
      for (const Pose& pose : poses.subspan(1)) before = core.checked(pose, before, rest.duration_s);
      out = core.start(rest);
      poses = poses.subspan(1);
    }
    if (poses.empty()) return out;
    const std::vector<StepResult> more = core.run(core.motions_to(poses), stop);
    out.insert(out.end(), more.begin(), more.end());
    return out;
  });
}

StepResult Simulation::peek(const Pose& pose, std::optional<double> dt) {
  return guarded([&] {
    if (core_->scene.scenario.cutting.erosion != ErosionMode::exact)
      throw BadInput("peek() needs cutting.erosion: exact");
    const FrameMotion motion = core_->motion_to(pose, dt);
    StepResult out;
    core_->compute([&] { out = result_of(core_->stepper.peek(motion)); });
    return out;
  });
}

Volume Simulation::fill() {
  return guarded([&] {
    core_->stepper.read_fill();
    return volume_of(core_->scene.bone.view(), [](std::uint8_t, std::uint16_t fill) {
      return static_cast<float>(fill) / float{FillBricks::kWhole};
    });
  });
}

Volume Simulation::density() const {
  return guarded([&] {
    return volume_of(core_->scene.bone.view(), [](std::uint8_t grade, std::uint16_t) {
      return static_cast<float>(DensityMapping::density_from_grade(grade));
    });
  });
}

double Simulation::removed_mm3() const {
  return core_->progress.removed_mm3;
}

std::optional<Pose> Simulation::pose() const {
  const std::optional<ToolPose>& pose = core_->progress.pose;
  return pose ? std::optional(pose_of(*pose)) : std::nullopt;
}

std::int64_t Simulation::frame() const {
  return core_->stepper.state().frame;
}

Simulation::State Simulation::state() {
  return guarded([&] {
    if (core_->failed) throw RunFailure(kFailed);
    core_->stepper.read_fill();
    auto parts = std::make_shared<State::Parts>(State::Parts{.bone = core_->identity,
                                                             .progress = core_->progress,
                                                             .before = core_->scene.bone.fill_before,
                                                             .fill = core_->scene.bone.fill});
    parts->progress.step = core_->stepper.state();
    return State(std::move(parts));
  });
}

void Simulation::restore(const State& state) {
  guarded([&] {
    if (core_->failed) throw RunFailure(kFailed);
    const State::Parts& saved = state.parts();
    if (saved.bone != core_->identity) throw BadInput("the state is one of another bone");
    core_->scene.bone.fill = saved.fill_on(core_->scene.bone.fill_before);
    core_->engine->restore(core_->scene.bone);
    core_->stepper.resume(saved.progress.step);
    core_->progress = saved.progress;
  });
}

}  // namespace reamsim
