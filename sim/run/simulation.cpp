#include "sim/run/simulation.h"

#include <fmt/core.h>
#include <algorithm>

#include "sim/base/error.h"
#include "sim/base/stopwatch.h"
#include "sim/engine/common/broad_phase.h"
#include "sim/engine/common/motion_windows.h"
#include "sim/engine/make_engine.h"
#include "sim/run/frame_basis.h"
#include "sim/run/frame_ledger.h"
#include "sim/scenario/picture_frames.h"
#include "sim/tool/outline.h"

namespace reamsim {

namespace {

/// The box of the voxels with bone, B, mm.
Aabb bone_box(const Voxmap& voxmap) {
  const VoxelBox voxels = bone_extent(voxmap);
  const Vec3 corner = voxmap.grid.origin_mm;
  return {corner + voxmap.grid.voxel_mm * voxels.first.cast<double>(),
          corner + voxmap.grid.voxel_mm * (voxels.last + Vec3i::Ones()).cast<double>()};
}

/// The box of the shell's points, which may lie half a cell outside the surface.
Aabb shell_box(const Tool& tool) {
  const Vec3 margin = Vec3::Constant(0.5 * tool.shell.cell_mm);
  return {tool.bounds.min - margin, tool.bounds.max + margin};
}

/// The box of the shell's points, or of the surface where it clips voxels.
Aabb cutting_box(const ReamingScene& scene) {
  if (scene.scenario.cutting.erosion != ErosionMode::exact) return shell_box(scene.tool);
  return scene.tool.clip_bounds().expanded(fit_outline(scene.tool.profile).bulge_mm);
}

/// Whether the spin moves the cutting surface. A surface of revolution that clips voxels is its own envelope.
bool is_moved_by_spin(const Scenario& scenario, const Tool& tool) {
  if (scenario.cutting.erosion == ErosionMode::exact) return tool.teeth.has_value();
  return tool.spin == ToolSpin::resolved;
}

/// The tool's origin at the first contact of a plunge that counts from it, B.
std::optional<Vec3> contact_of(const ReamingScene& scene) {
  const std::optional<FirstContact> contact = scene.first_contact();
  return contact ? std::optional(contact->origin_mm) : std::nullopt;
}

/// The run of a pass: the batch, its frames, and the energy balance.
class Simulation {
 public:
  Simulation(ReamingScene& scene, Engine& engine, FrameSink& sink, Report& report)
      : scene_(scene),
        engine_(engine),
        sink_(sink),
        report_(report),
        tool_box_(cutting_box(scene)),
        bone_box_(bone_box(*scene.bone.voxmap)),
        ledger_(scene.bone.voxmap->grid.voxel_mm3(), scene.motion.frame_s(),
                scene.scenario.cutting.law == CuttingLaw::per_point && scene.tool.spin == ToolSpin::resolved,
                contact_of(scene)),
        resolved_(is_moved_by_spin(scene.scenario, scene.tool)),
        exact_(scene.scenario.cutting.erosion == ErosionMode::exact),
        windows_([this](std::int64_t frame) { return args_of(frame); }, scene.motion.last_frame(), tool_box_),
        max_step_mm_(scene.scenario.engine.max_step_voxels * scene.bone.voxmap->grid.voxel_mm) {}

  /// The main loop. Substeps of several frames are one batch, which ends with a frame that has a picture.
  SimulationState run(const RunControl& control) {
    const std::int64_t first = scene_.motion.first_frame, last = scene_.motion.last_frame();
    const std::vector<std::int64_t> pictures =
        picture_frames(scene_.scenario.render, scene_.last_frame(), scene_.contact);
    const auto has_picture = [&](std::int64_t frame) { return std::ranges::binary_search(pictures, frame); };
    const bool had_ended = control.from && control.from->frame == last;
    if (control.from) resume(*control.from);
    if (first == 0 && !control.from) snapshot(0);  // the bone before the first pose removes any
    if (!control.from || control.from->frame < first) {
      start(first);
      if (first > 0 && has_picture(first)) snapshot(first);
    }
    for (std::int64_t frame = state_.frame + 1; frame <= last; ++frame) {
      PendingFrame& pending = open_frame(frame);
      for (const Substep& substep : substeps_of(pending)) {
        if (const auto voi = broad_phase(substep, pending)) enqueue(substep, *voi, pending);
      }
      const bool picture = has_picture(frame);
      if (!picture && frame != last && !is_batch(frame)) continue;
      collect();
      record();
      if (picture) snapshot(frame);
      control.progress(frame, scene_.last_frame());
      finish_batch(control);
    }
    if (!had_ended && !state_.touched && !control.warned_of_no_contact) {
      report_.warn(name_of_pass() +
                   "the tool never touches the bone: check motion and, if it is used, the glenoid frame");
    }
    engine_.read_fill(*scene_.bone.voxmap, scene_.bone.fill);
    return state();
  }

 private:
  [[nodiscard]] SimulationState state() const {
    SimulationState out = state_;
    out.ledger = ledger_.sums();
    return out;
  }

  void resume(const SimulationState& from) {
    state_ = from;
    ledger_.restore(from.ledger);
  }

  /// Whether the pending frames, up to this one, are a batch. Slow frames make small ones, so that a run stops soon
  /// when it is asked to. Results do not depend on batches.
  [[nodiscard]] bool is_batch(std::int64_t frame) const {
    constexpr double kMostSeconds = 0.2;
    const auto count = static_cast<double>(pending_.size());
    return (frame + 1) % scene_.scenario.engine.batch_frames == 0 || count * frame_s_ > kMostSeconds;
  }

  /// Saves the state where that is due, and ends the run where that is asked for.
  void finish_batch(const RunControl& control) {
    batch_watch_ = Stopwatch();
    const bool stop = control.stop();
    if (stop || control.save_due()) {
      engine_.read_fill(*scene_.bone.voxmap, scene_.bone.fill);
      control.save(state());
    }
    if (stop) throw Interrupted();
  }

  /// The first frame of the pass. Where voxels are clipped, bone in the tool's first pose is removed without force.
  void start(std::int64_t first) {
    ledger_.begin_pass();
    state_.touched = false;
    PendingFrame& pending = open_frame(first);
    const Substep rest{.pose = pending.pose, .duration_s = scene_.motion.frame_s()};
    if (exact_) {
      if (const auto voi = broad_phase(rest, pending)) enqueue(rest, *voi, pending, RS_LAW_NONE);
    }
    collect();
    record();
  }

  PendingFrame& open_frame(std::int64_t frame) {
    const Motion& motion = scene_.motion;
    const ToolPose before = motion.pose_of(std::max(frame - 1, motion.first_frame));
    return pending_.emplace_back(
        PendingFrame{.frame = frame, .pass = motion.pass, .before = before, .pose = motion.pose_of(frame), .cut = {}});
  }

  std::vector<Substep> substeps_of(PendingFrame& pending) const {
    const int n = count_substeps(pending.before, pending.pose, scene_.tool, resolved_, max_step_mm_);
    pending.substeps = n;
    std::vector<Substep> out;
    for (int i = 0; i < n; ++i) {
      out.push_back(make_substep(pending.before, pending.pose, double(i) / n, double(i + 1) / n,
                                 scene_.motion.frame_s(), pending.frame));
    }
    return out;
  }

  /// The volume of interest in the shell's frame; nullopt where the tool cannot touch bone.
  std::optional<Aabb> broad_phase(const Substep& substep, PendingFrame& pending) const {
    const Stopwatch watch;
    const Rigid shell_from_bone = bone_from_shell(substep.pose, resolved_).inverse();
    const std::optional<Aabb> voi = reamsim::broad_phase(tool_box_, bone_box_, shell_from_bone);
    pending.broad_phase_s += watch.seconds();
    return voi;
  }

  /// The substep of a frame that has one.
  [[nodiscard]] std::optional<SubstepArgs> args_of(std::int64_t frame) const {
    if (frame <= scene_.motion.first_frame) return std::nullopt;
    const ToolPose before = scene_.motion.pose_of(frame - 1), pose = scene_.motion.pose_of(frame);
    if (count_substeps(before, pose, scene_.tool, resolved_, max_step_mm_) != 1) return std::nullopt;
    return make_args(make_substep(before, pose, 0, 1, scene_.motion.frame_s(), frame), tool_box_, scene_.tool.shell,
                     scene_.bone.voxmap->grid, scene_.scenario.cutting, resolved_);
  }

  /// `law` overrides the scenario's.
  void enqueue(const Substep& substep, const Aabb& voi, PendingFrame& pending, std::optional<rs_i32> law = {}) {
    if (engine_.full()) collect();
    SubstepArgs args =
        make_args(substep, voi, scene_.tool.shell, scene_.bone.voxmap->grid, scene_.scenario.cutting, resolved_);
    if (law) args.law = *law;
    const bool windowed = exact_ && !law && !resolved_ && scene_.scenario.engine.tuning.windows;
    engine_.enqueue(args, windowed ? windows_.of(pending.frame) : nullptr);
    pending.cut.emplace_back(enqueued_++, substep);
  }

  /// Appends the engine's results of the enqueued substeps.
  void collect() {
    const Batch part = engine_.collect();
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    append(batch_.sums, part.sums);
    append(batch_.times, part.times);
    append(batch_.basis, part.basis);
    append(removed_, engine_.take_removed());
  }

  /// Closes the frames of the batch: fill of the bone, rows, and removed voxels.
  void record() {
    // Exact erosion: read_fill() includes the removed voxels.
    for (const auto& [voxel, frame] : removed_) {
      if (!exact_) scene_.bone.fill.set(scene_.bone.voxmap->grid.coord(voxel), 0);
    }
    sink_.removed(removed_);
    for (const PendingFrame& pending : pending_) {
      const FrameResult result = ledger_.close(pending, batch_.sums);
      FrameTimes times{.broad_phase_s = pending.broad_phase_s};
      for (const auto& [place, substep] : pending.cut) {
        times.detect_s += batch_.times[place].detect_s;
        times.cut_s += batch_.times[place].cut_s;
      }
      warn_of(result);
      sink_.frame(result, times);
      if (!batch_.basis.empty()) sink_.basis(basis_rows(pending, batch_.basis));
      state_.frame = pending.frame;
    }
    frame_s_ = batch_watch_.seconds() / static_cast<double>(std::max<std::size_t>(pending_.size(), 1));
    pending_.clear();
    batch_ = {};
    enqueued_ = 0;
    removed_.clear();
  }

  void snapshot(std::int64_t frame) {
    engine_.read_fill(*scene_.bone.voxmap, scene_.bone.fill);
    sink_.snapshot(frame, scene_.bone.fill);
  }

  /// "pass 2: " in a run of several.
  [[nodiscard]] std::string name_of_pass() const {
    const bool several = scene_.motion.pass > 1 || !scene_.later_passes.empty();
    return several ? "pass " + std::to_string(scene_.motion.pass) + ": " : "";
  }

  /// Warns once of conditions that the user may not intend.
  void warn_of(const FrameResult& result) {
    if (result.contacts == 0) return;
    const std::string at = "frame " + std::to_string(result.frame);
    const std::int64_t first = scene_.motion.first_frame;
    if (result.frame == first) {
      report_.warn(fmt::format("the tool starts in the bone: {:.3g} mm3 were removed at {}, without force",
                               result.removed_mm3, at));
    }
    if (!state_.touched && result.frame == first + 1 && !exact_) {
      report_.warn("the tool starts in contact with the bone: the force of the first frames is not meaningful");
    }
    if (!state_.warned_of_no_spin && result.frame > first && result.pose.spin_rpm == 0) {
      report_.warn(at + ": spindle speed is zero: forces are those of a non-rotating tool");
      state_.warned_of_no_spin = true;
    }
    state_.touched = true;
  }

  ReamingScene& scene_;
  Engine& engine_;
  FrameSink& sink_;
  Report& report_;
  Aabb tool_box_;
  Aabb bone_box_;
  FrameLedger ledger_;
  bool resolved_;
  bool exact_;
  MotionWindows windows_;
  double max_step_mm_;
  std::vector<PendingFrame> pending_;
  Batch batch_;               ///< of the pending frames
  std::size_t enqueued_ = 0;  ///< substeps of these frames
  RemovedFrames removed_;
  Stopwatch batch_watch_;
  double frame_s_ = 0;     ///< wall time of a frame in the last batch
  SimulationState state_;  ///< without the ledger's sums
};

}  // namespace

std::unique_ptr<Engine> load_engine(const ReamingScene& scene, EngineDevices& devices) {
  try {
    return make_engine_on(devices, scene.scenario, scene.bone, scene.tool);
  } catch (const InputError& error) {
    throw scene.scenario.keys.located(error);
  }
}

std::unique_ptr<Engine> load_engine(const ReamingScene& scene) {
  EngineDevices devices;
  return load_engine(scene, devices);
}

SimulationState simulate(ReamingScene& scene, Engine& engine, FrameSink& sink, const RunControl& control,
                         Report& report) {
  return Simulation(scene, engine, sink, report).run(control);
}

RunCost estimate_cost(const ReamingScene& scene) {
  const double max_step_mm = scene.scenario.engine.max_step_voxels * scene.bone.voxmap->grid.voxel_mm;
  RunCost cost{.frames = scene.last_frame()};
  const auto add = [&](const Tool& tool, const PoseSequence& poses) {
    for (std::size_t k = 1; k < poses.size(); ++k) {
      cost.substeps +=
          count_substeps(poses[k - 1], poses[k], tool, is_moved_by_spin(scene.scenario, tool), max_step_mm);
    }
  };
  add(scene.tool, scene.motion.poses);
  for (const Pass& pass : scene.later_passes) add(pass.tool, pass.motion.poses);
  return cost;
}

}  // namespace reamsim
