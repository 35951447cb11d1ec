#include <cmath>
#include <new>
#include <utility>

#include "sim/api/reamsim/simulation.h"
#include "sim/base/error.h"
#include "sim/engine/common/motion_windows.h"
#include "sim/motion/key_track.h"
#include "sim/run/frame_stepper.h"
#include "sim/run/simulation.h"
#include "sim/scenario/parse.h"

namespace reamsim {

namespace {

/// Calls work(), and turns its exceptions into those of the library.
template <class Work>
auto guarded(const Work& work) {
  try {
    return work();
  } catch (const Error&) {
    throw;
  } catch (const InputError& error) {
    throw BadInput(error.what());
  } catch (const std::bad_alloc&) {
    throw RunFailure("not enough memory");
  } catch (const std::exception& error) {
    throw RunFailure(error.what());
  }
}

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
          .balance = r.balance};
}

/// The simulation has not been given its first pose.
constexpr const char* kNotStarted = "call start() before step(), run() and peek()";

}  // namespace

namespace library {

/// Collects rows.
class Rows final : public FrameSink {
 public:
  void frame(const FrameResult& result, const FrameTimes&) override { rows.push_back(result_of(result)); }
  void snapshot(std::int64_t, FillBricks&) override {}
  void removed(const RemovedFrames&) override {}
  std::vector<StepResult> rows;
};

}  // namespace library

struct Simulation::State::Parts {
  StepState step;
  std::optional<ToolPose> pose;
  double time_s = 0;
  double removed_mm3 = 0;
  bool uneven = false;
  VoxelGrid grid;
  FillBricks fill;
};

struct Simulation::Core {
  explicit Core(const std::string& path, const std::vector<std::string>& set)
      : scene(load(parse_scenario(path, set), report)),
        engine(load_engine(scene)),
        stepper(scene, *engine, rows, report) {}

  static ReamingScene load(const Scenario& scenario, Report& report) {
    ReamingScene out = load_scene(scenario, report);
    if (!out.later_passes.empty()) throw InputError("motion.passes: a simulation has one tool; use motion.plunge");
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
    if (!at) throw BadInput(kNotStarted);
    const double duration_s = dt.value_or(scene.motion.frame_s());
    if (!(duration_s > 0) || !std::isfinite(duration_s)) throw BadInput("dt: a time above 0 s is needed");
    const std::int64_t frame = stepper.state().frame + 1;
    // Equal steps have the times of a run, without accumulated rounding.
    const bool even = !dt && !uneven;
    return {.frame = frame,
            .before = *at,
            .pose = checked(pose, at, duration_s),
            .duration_s = duration_s,
            .time_s = even ? static_cast<double>(frame) * duration_s : time_s + duration_s};
  }

  /// Takes the rows since the last call.
  std::vector<StepResult> take(const FrameMotion& last) {
    at = last.pose;
    time_s = last.time_s;
    std::vector<StepResult> out = std::exchange(rows.rows, {});
    for (const StepResult& row : out) removed_mm3 += row.removed_mm3;
    return out;
  }

  Report report;
  ReamingScene scene;
  std::unique_ptr<Engine> engine;
  library::Rows rows;
  FrameStepper stepper;
  std::optional<ToolPose> at;
  double time_s = 0;
  double removed_mm3 = 0;
  bool uneven = false;  ///< steps had a time of their own
};

Simulation::Simulation(const std::string& scenario, const std::vector<std::string>& set)
    : core_(guarded([&] { return std::make_unique<Core>(scenario, set); })) {}
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;
Simulation::~Simulation() = default;

double Simulation::frame_s() const {
  return core_->scene.motion.frame_s();
}

std::vector<Pose> Simulation::planned_poses() const {
  return guarded([&] {
    std::vector<Pose> out;
    for (const ToolPose& pose : core_->scene.motion.poses) out.push_back(pose_of(pose));
    return out;
  });
}

std::vector<std::string> Simulation::warnings() const {
  return core_->report.warnings;
}

StepResult Simulation::start(const Pose& pose) {
  return guarded([&] {
    if (core_->at) throw BadInput("start() has been called; restore() an earlier state");
    const ToolPose first = core_->checked(pose, std::nullopt, 0);
    const FrameMotion rest{.before = first, .pose = first, .duration_s = frame_s()};
    core_->stepper.start(rest);
    return core_->take(rest).back();
  });
}

StepResult Simulation::step(const Pose& pose, std::optional<double> dt) {
  return guarded([&] {
    const FrameMotion motion = core_->motion_to(pose, dt);
    core_->uneven = core_->uneven || dt.has_value();
    core_->stepper.add(motion);
    core_->stepper.finish_batch();
    return core_->take(motion).back();
  });
}

std::vector<StepResult> Simulation::run(std::span<const Pose> poses) {
  return guarded([&] {
    if (poses.empty()) return std::vector<StepResult>{};
    Core& core = *core_;
    const std::int64_t first = core.stepper.state().frame + 1;
    std::vector<FrameMotion> motions{core.motion_to(poses.front(), {})};
    for (const Pose& pose : poses.subspan(1)) {
      FrameMotion next = motions.back();
      next.before = next.pose;
      next.pose = core.checked(pose, next.before, next.duration_s);
      ++next.frame;
      next.time_s = core.uneven ? next.time_s + next.duration_s : static_cast<double>(next.frame) * next.duration_s;
      motions.push_back(next);
    }
    const auto args_of = [&](std::int64_t frame) -> std::optional<SubstepArgs> {
      const std::int64_t i = frame - first;
      if (i < 0 || i >= std::ssize(motions)) return std::nullopt;
      return core.stepper.single_args(motions[static_cast<std::size_t>(i)]);
    };
    MotionWindows windows(args_of, motions.back().frame, core.stepper.tool_box());
    const bool windowed = core.stepper.can_use_windows();
    for (const FrameMotion& motion : motions) {
      core.stepper.add(motion, windowed ? windows.of(motion.frame) : nullptr);
      if (core.stepper.batch_frames() >= static_cast<std::size_t>(core.scene.scenario.engine.batch_frames))
        core.stepper.finish_batch();
    }
    core.stepper.finish_batch();
    return core.take(motions.back());
  });
}

StepResult Simulation::peek(const Pose& pose, std::optional<double> dt) {
  return guarded([&] {
    if (core_->scene.scenario.cutting.erosion != ErosionMode::exact)
      throw BadInput("peek() needs cutting.erosion: exact");
    return result_of(core_->stepper.peek(core_->motion_to(pose, dt)));
  });
}

Volume Simulation::fill() {
  return guarded([&] {
    core_->stepper.read_fill();
    const VoxelGrid& grid = core_->scene.bone.voxmap->grid;
    Volume out{{grid.dims.x(), grid.dims.y(), grid.dims.z()}, grid.voxel_mm, array_of(grid.origin_mm), {}};
    out.values.assign(static_cast<std::size_t>(grid.size()), 0.0F);
    for_each_bone_voxel(core_->scene.bone.view(), [&](const Vec3i& voxel, std::uint8_t, std::uint16_t fill) {
      out.values[static_cast<std::size_t>(grid.index(voxel))] = static_cast<float>(fill) / float{FillBricks::kWhole};
    });
    return out;
  });
}

Volume Simulation::density() const {
  return guarded([&] {
    const Voxmap& voxmap = *core_->scene.bone.voxmap;
    const VoxelGrid& grid = voxmap.grid;
    Volume out{{grid.dims.x(), grid.dims.y(), grid.dims.z()}, grid.voxel_mm, array_of(grid.origin_mm), {}};
    out.values.resize(static_cast<std::size_t>(grid.size()));
    for (std::int64_t e = 0; e < grid.size(); ++e) {
      out.values[static_cast<std::size_t>(e)] =
          static_cast<float>(DensityMapping::density_from_grade(voxmap.grade.get(grid.coord(e))));
    }
    return out;
  });
}

double Simulation::removed_mm3() const {
  return core_->removed_mm3;
}

Simulation::State Simulation::state() {
  return guarded([&] {
    core_->stepper.read_fill();
    return State(std::make_shared<State::Parts>(State::Parts{core_->stepper.state(), core_->at, core_->time_s,
                                                             core_->removed_mm3, core_->uneven,
                                                             core_->scene.bone.voxmap->grid, core_->scene.bone.fill}));
  });
}

void Simulation::restore(const State& state) {
  guarded([&] {
    const State::Parts& saved = state.parts();
    const VoxelGrid& grid = core_->scene.bone.voxmap->grid;
    if (saved.grid.dims != grid.dims || saved.grid.voxel_mm != grid.voxel_mm ||
        saved.grid.origin_mm != grid.origin_mm) {
      throw BadInput("the state is one of another bone");
    }
    core_->scene.bone.fill = saved.fill;
    core_->engine->restore(core_->scene.bone);
    core_->stepper.resume(saved.step);
    core_->at = saved.pose;
    core_->time_s = saved.time_s;
    core_->removed_mm3 = saved.removed_mm3;
    core_->uneven = saved.uneven;
  });
}

}  // namespace reamsim
