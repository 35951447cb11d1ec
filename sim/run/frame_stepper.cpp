// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/run/frame_stepper.h"

#include <fmt/core.h>
#include <map>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "sim/bone/voxmap/voxmap.h"
#include "sim/tool/profile.h"

namespace reamsim {

namespace {

constexpr double kRadPerRpm_s = 2 * std::numbers::pi / 60;

/// The tool's origin at the beginning of a substep, B.
Vec3 start_of(const Substep& substep, const PendingFrame& frame) {
  if (frame.substeps == 1) return frame.before.position_mm;
  return substep.pose.position_mm - substep.duration_s * substep.origin_velocity_mm_s;
}

/// The values of a BasisRow from p_mm2 on, summed over the substeps of a frame, in B.
using BasisSums = Eigen::Matrix<double, kBasisRowValues, 1>;

void add_substep(const Substep& substep, int substeps, const GradeBasis& basis, BasisSums& sums) {
  const Mat3 bone_from_tool = bone_from_shell(substep.pose, false).linear();
  const Vec3 p = bone_from_tool * basis.force(), p_torque = bone_from_tool * basis.torque();
  const Vec3 n = bone_from_tool * basis.normal_force(), n_torque = bone_from_tool * basis.normal_torque();
  int at = 0;
  for (const Vec3* mean : {&p, &p_torque, &n, &n_torque}) sums.segment<3>(3 * at++) += *mean / substeps;
  sums.tail<4>() +=
      Vec4(work_of(substep, p, p_torque), work_of(substep, n, n_torque), basis.energy(), basis.floor_energy());
}

BasisRow row_of(std::int64_t frame, int grade, const BasisSums& sums) {
  BasisRow row;
  row.frame = static_cast<std::int32_t>(frame);
  row.grade = grade;
  row.density_g_cm3 = static_cast<float>(DensityMapping::density_from_grade(static_cast<std::uint8_t>(grade)));
  Eigen::Map<Eigen::Matrix<float, kBasisRowValues, 1>>(row.p_mm2) = sums.cast<float>();
  return row;
}

/// The rows of force_basis.npy of a frame, ascending grades: means of force and torque over the substeps, sums of work
/// and energies, as EnergyBalance::close() has them. `substeps`: of the batch.
std::vector<BasisRow> basis_rows(const PendingFrame& frame, const std::vector<SubstepBasis>& substeps) {
  std::map<int, BasisSums> by_grade;
  for (const auto& [place, substep] : frame.cut) {
    for (const GradeBasis& basis : substeps[place]) {
      BasisSums& sums = by_grade.try_emplace(basis.grade, BasisSums::Zero()).first->second;
      add_substep(substep, frame.substeps, basis, sums);
    }
  }
  std::vector<BasisRow> rows;
  for (const auto& [grade, sums] : by_grade) rows.push_back(row_of(frame.frame, grade, sums));
  return rows;
}

/// The box of the shell's points, which may lie half a cell outside the surface, or of the surface that clips voxels.
Aabb cutting_box(const SimulationInput& scene) {
  if (scene.scenario.cutting.erosion != ErosionMode::exact) {
    return scene.tool.bounds.expanded(0.5 * scene.tool.shell.cell_mm);
  }
  return scene.tool.clip_bounds().expanded(fit_outline(scene.tool.profile).bulge_mm);
}

}  // namespace

FrameResult EnergyBalance::close(const PendingFrame& frame, const std::vector<SubstepSums>& sums) {
  FrameResult out{.frame = frame.frame,
                  .pass = frame.pass,
                  .time_s = frame.time_s,
                  .pose = frame.pose,
                  .push = frame.push,
                  .deflection_mm = frame.deflection_mm};
  rs_i64 removed = 0;
  std::optional<Vec3> touched_from_mm;  // where the first substep with contact begins
  for (const auto& [slot, substep] : frame.cut) {
    const SubstepSums& sum = sums[slot];
    const Mat3 bone_from_sums = bone_from_shell(substep.pose, sums_rotate_).linear();
    const Vec3 force = bone_from_sums * force_of(sum);
    const Vec3 torque = bone_from_sums * torque_of(sum);
    run.work_mj += work_of(substep, force, torque);
    out.force_n += force / frame.substeps;
    out.torque_nmm += torque / frame.substeps;
    out.energy_mj += static_cast<double>(sum.energy) / RS_ENERGY_SCALE;
    out.floor_energy_mj += static_cast<double>(sum.floor_energy) / RS_ENERGY_SCALE;
    if ((sum.contacts > 0 || !force.isZero(0)) && !touched_from_mm) touched_from_mm = start_of(substep, frame);
    out.contacts += sum.contacts;
    removed += sum.removed;
  }
  out.removed_mm3 = static_cast<double>(removed) / RS_WHOLE_FILL * voxel_mm3_;
  run.floor_mj += out.floor_energy_mj;
  run.cut_mj += out.energy_mj;
  out.balance = balance();

  const Vec3 tool_z = frame.pose.orientation * Vec3::UnitZ();
  out.axial_force_n = out.force_n.dot(tool_z);
  // The tool spins about −z of T, so the torque of the bone on it is about +z.
  out.spin_torque_nmm = out.torque_nmm.dot(tool_z);
  if (out.push) out.push->drill_power_w = 1e-3 * out.spin_torque_nmm * out.pose.spin_rpm * kRadPerRpm_s;
  if (touched_from_mm && !run.first_contact_mm)
    run.first_contact_mm = contact_ ? contact_->origin_mm : *touched_from_mm;
  if (run.first_contact_mm) out.depth_mm = -(frame.pose.position_mm - *run.first_contact_mm).dot(tool_z);
  return out;
}

Aabb bone_box(const Voxmap& voxmap) {
  const VoxelBox voxels = bone_extent(voxmap);
  const Vec3 corner = voxmap.grid.origin_mm;
  return {corner + voxmap.grid.voxel_mm * voxels.first.cast<double>(),
          corner + voxmap.grid.voxel_mm * (voxels.last + Vec3i::Ones()).cast<double>()};
}

bool is_moved_by_spin(const Scenario& scenario, const Tool& tool) {
  if (scenario.cutting.erosion == ErosionMode::exact) return tool.teeth.has_value();
  return tool.spin == ToolSpin::resolved;
}

FrameStepper::FrameStepper(SimulationInput& scene, Engine& engine, FrameSink& sink, Diagnostics& report)
    : scene_(scene),
      engine_(engine),
      sink_(sink),
      report_(report),
      tool_box_(cutting_box(scene)),
      bone_box_(bone_box(*scene.bone.voxmap)),
      energy_(scene.bone.voxmap->grid.voxel_mm3(),
              scene.scenario.cutting.law == CuttingLaw::per_point && scene.tool.spin == ToolSpin::resolved,
              scene.first_contact()),
      resolved_(is_moved_by_spin(scene.scenario, scene.tool)),
      exact_(scene.scenario.cutting.erosion == ErosionMode::exact),
      max_step_mm_(scene.scenario.engine.max_step_voxels * scene.bone.voxmap->grid.voxel_mm) {}

void FrameStepper::start(const FrameMotion& motion) {
  energy_.run.first_contact_mm.reset();  // of another tool
  state_.touched = false;
  PendingFrame& pending = begin_frame(motion);
  const Substep rest{.pose = motion.pose, .duration_s = motion.duration_s};
  if (exact_) {
    if (const auto voi = broad_phase(rest, pending)) {
      SubstepArgs args = args_of(rest, *voi);
      args.law = RS_LAW_NONE;
      enqueue(rest, args, nullptr, pending);
    }
  }
  finish_batch();
}

void FrameStepper::add(const FrameMotion& motion, const std::shared_ptr<const MotionWindow>& window) {
  enqueue_motion(motion, count_substeps(motion.before, motion.pose, scene_.tool, resolved_, max_step_mm_), window,
                 begin_frame(motion));
}

SubstepSums FrameStepper::add_part(const FrameMotion& part, int i, int parts) {
  if (i == 0) begin_frame(part).substeps = parts;
  PendingFrame& pending = pending_.back();
  pending.pose = part.pose;
  pending.time_s = part.time_s;
  const Substep substep = make_substep(part.before, part.pose, 0, 1, part.duration_s, part.frame);
  const auto voi = broad_phase(substep, pending);
  if (!voi) return {};
  enqueue(substep, args_of(substep, *voi), nullptr, pending);
  collect();
  return batch_.sums.back();
}

bool FrameStepper::is_full(int most) const {
  constexpr double kMostSeconds = 0.2;
  return std::ssize(pending_) >= most || static_cast<double>(pending_.size()) * frame_wall_s_ > kMostSeconds;
}

void FrameStepper::snapshot(std::int64_t frame) {
  read_fill();
  sink_.snapshot(frame, scene_.bone.fill);
}

std::vector<SubstepSums> FrameStepper::evaluate(const std::vector<FrameMotion>& motions) {
  if (uncut_) throw std::logic_error("a part of the batch has not been cut");
  std::vector<SubstepSums> out(motions.size());
  std::vector<std::size_t> reached;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    PendingFrame timed;
    const FrameMotion& m = motions[i];
    const Substep substep = make_substep(m.before, m.pose, 0, 1, m.duration_s, m.frame);
    const auto voi = broad_phase(substep, timed);
    if (!voi) continue;
    SubstepArgs args = args_of(substep, *voi);
    args.erosion = RS_EROSION_TRIAL;
    engine_.enqueue(args);
    reached.push_back(i);
  }
  if (reached.empty()) return out;
  const Batch batch = engine_.collect();
  for (std::size_t i = 0; i < reached.size(); ++i) out[reached[i]] = batch.sums[i];
  return out;
}

FrameResult FrameStepper::peek(const FrameMotion& m) {
  PendingFrame frame = pending_of(m);
  EnergyBalance as_it_would_be = energy_;
  const int n = count_substeps(m.before, m.pose, scene_.tool, resolved_, max_step_mm_);
  if (n == 1) {
    frame.cut = {{0, make_substep(m.before, m.pose, 0, 1, m.duration_s, m.frame)}};
    return as_it_would_be.close(frame, evaluate({m}));
  }
  // Each substep needs the bone that those before it leave, so the motion cuts, and the bone is put back.
  read_fill();
  enqueue_motion(m, n, nullptr, frame);
  if (frame.cut.empty()) return as_it_would_be.close(frame, {});
  collect();
  engine_.restore(scene_.bone.view());
  const FrameResult out = as_it_would_be.close(frame, batch_.sums);
  clear_batch();
  return out;
}

std::optional<SubstepArgs> FrameStepper::single_args(const FrameMotion& m) const {
  if (count_substeps(m.before, m.pose, scene_.tool, resolved_, max_step_mm_) != 1) return std::nullopt;
  return args_of(make_substep(m.before, m.pose, 0, 1, m.duration_s, m.frame), tool_box_);
}

StepState FrameStepper::state() const {
  StepState out = state_;
  out.energy = energy_.run;
  return out;
}

void FrameStepper::resume(const StepState& from) {
  state_ = from;
  energy_.run = from.energy;
}

std::string FrameStepper::name_of_pass() const {
  const bool several = scene_.motion.pass > 1 || !scene_.later_passes.empty();
  return several ? "pass " + std::to_string(scene_.motion.pass) + ": " : "";
}

PendingFrame& FrameStepper::begin_frame(const FrameMotion& motion) {
  if (pending_.empty()) batch_watch_ = Stopwatch();
  return pending_.emplace_back(pending_of(motion));
}

void FrameStepper::enqueue_motion(const FrameMotion& motion, int substeps,
                                  const std::shared_ptr<const MotionWindow>& window, PendingFrame& pending) {
  pending.substeps = substeps;
  for (int i = 0; i < substeps; ++i) {
    const Substep substep = make_substep(motion.before, motion.pose, double(i) / substeps, double(i + 1) / substeps,
                                         motion.duration_s, motion.frame);
    if (const auto voi = broad_phase(substep, pending)) enqueue(substep, args_of(substep, *voi), window, pending);
  }
}

/// The volume of interest in the shell's frame; nullopt where the tool cannot touch bone.
std::optional<Aabb> FrameStepper::broad_phase(const Substep& substep, PendingFrame& pending) const {
  const Stopwatch watch;
  const Rigid shell_from_bone = bone_from_shell(substep.pose, resolved_).inverse();
  const std::optional<Aabb> voi = reamsim::broad_phase(tool_box_, bone_box_, shell_from_bone);
  pending.broad_phase_s += watch.seconds();
  return voi;
}

void FrameStepper::enqueue(const Substep& substep, const SubstepArgs& args, std::shared_ptr<const MotionWindow> window,
                           PendingFrame& pending) {
  if (engine_.full()) collect();
  engine_.enqueue(args, std::move(window));
  uncut_ = cut_since_read_ = true;
  pending.cut.emplace_back(enqueued_++, substep);
}

void FrameStepper::collect() {
  if (!std::exchange(uncut_, false)) return;
  const Batch part = engine_.collect();
  const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  append(batch_.sums, part.sums);
  append(batch_.times, part.times);
  append(batch_.basis, part.basis);
  append(removed_, engine_.take_removed());
}

void FrameStepper::record() {
  // Exact erosion: read_fill() includes the removed voxels.
  for (const auto& [voxel, frame] : removed_) {
    if (!exact_) scene_.bone.fill.set(scene_.bone.voxmap->grid.coord(voxel), 0);
  }
  sink_.removed(removed_);
  for (const PendingFrame& pending : pending_) {
    const FrameResult result = energy_.close(pending, batch_.sums);
    FrameTimes times{.broad_phase_s = pending.broad_phase_s};
    for (const auto& [place, substep] : pending.cut) {
      times.detect_s += batch_.times[place].detect_s;
      times.cut_s += batch_.times[place].cut_s;
    }
    warn_of(result);
    sink_.frame(result, times);
    if (!batch_.basis.empty()) sink_.basis(basis_rows(pending, batch_.basis));
    state_.frame = pending.frame;
    last_ = result;
  }
  if (!pending_.empty()) frame_wall_s_ = batch_watch_.seconds() / static_cast<double>(pending_.size());
  pending_.clear();
  clear_batch();
}

void FrameStepper::clear_batch() {
  batch_ = {};
  enqueued_ = 0;
  removed_.clear();
}

void FrameStepper::warn_of(const FrameResult& result) {
  if (!result.in_contact()) return;
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

}  // namespace reamsim
