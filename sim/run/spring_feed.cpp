// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <algorithm>
#include <cmath>

#include "sim/run/feed.h"
#include "sim/tool/tool_path.h"

namespace reamsim {

namespace {

/// The part of engine.max_step_voxels that is left for the change of the deflection in a substep.
constexpr double kStepOfDeflection = 0.5;

/// The motion over `times` its time at the same velocity.
FrameMotion prolonged(const FrameMotion& m, double times) {
  FrameMotion out = m;
  const Vec3 turn = times * rotation_vector(m.before.orientation, m.pose.orientation);
  out.pose.position_mm = m.before.position_mm + times * (m.pose.position_mm - m.before.position_mm);
  if (!turn.isZero()) {
    out.pose.orientation = Quat(Eigen::AngleAxisd(turn.norm(), turn.normalized())) * m.before.orientation;
  }
  out.pose.spin_angle_rad = m.before.spin_angle_rad + times * (m.pose.spin_angle_rad - m.before.spin_angle_rad);
  out.duration_s = times * m.duration_s;
  return out;
}

class SpringFeed : public PlannedFeed {
 public:
  SpringFeed(const SimulationInput& scene, FrameStepper& stepper, Diagnostics& report)
      : PlannedFeed(scene),
        settings_(*scene.scenario.motion.compliance),
        stepper_(stepper),
        report_(report),
        frame_s_(scene.motion.frame_s()),
        resolved_(is_moved_by_spin(scene.scenario, scene.tool)),
        step_mm_(scene.scenario.engine.max_step_voxels * scene.bone.voxmap->grid.voxel_mm),
        loss_mm_(smallest_advance_mm(scene.bone.voxmap->grid.voxel_mm)) {}

  void start() override {
    release();
    const std::int64_t first = scene().motion.first_frame;
    const ToolPose pose = scene().motion.pose_of(first);
    stepper_.start({.frame = first,
                    .before = pose,
                    .pose = pose,
                    .duration_s = frame_s_,
                    .time_s = static_cast<double>(first) * frame_s_},
                   {}, Vec3(Vec3::Zero()));
  }
  void resume(const SimulationState& from) override { springs_ = from.springs; }

  void add(std::int64_t frame) override {
    const ToolPose begin = scene().motion.pose_of(frame - 1), end = scene().motion.pose_of(frame);
    const double planned_mm = bound_mm(begin, end, deflection_mm().norm());
    const int parts = std::max(1, static_cast<int>(std::ceil(planned_mm / ((1 - kStepOfDeflection) * step_mm_))));
    bool limited = false, balanced = true;
    for (int i = 0; i < parts; ++i) {
      const FrameMotion plan{.frame = frame,
                             .before = interpolate(begin, end, static_cast<double>(i) / parts),
                             .pose = interpolate(begin, end, static_cast<double>(i + 1) / parts),
                             .duration_s = frame_s_ / parts,
                             .time_s = static_cast<double>(frame) * frame_s_};
      const Deflection found = cut_part(plan, i, parts);
      limited |= found.limited;
      balanced &= found.balanced;
    }
    springs_.limited_frames += limited ? 1 : 0;
    springs_.unbalanced_frames += balanced ? 0 : 1;
    stepper_.set_deflection(deflection_mm());
  }
  /// The next deflection depends on the bone that this one leaves.
  [[nodiscard]] bool ends_batch(std::int64_t) const override { return true; }
  void take(const FrameResult&) override {}

  void warn_at_end() override {
    if (!scene().later_passes.empty()) return;
    if (springs_.limited_frames > 0) {
      report_.warn(
          fmt::format("motion.compliance: in {} frames the springs move the tool by engine.max_step_voxels and no "
                      "further; add damping_n_s_mm for a slower return",
                      springs_.limited_frames));
    }
    if (springs_.unbalanced_frames > 0) {
      report_.warn(fmt::format(
          "motion.compliance: in {} frames spring and bone are out of balance, by up to {:.3g} N, because the force "
          "jumps: the tool chatters or loses contact; raise damping_n_s_mm, or motion.frame_rate_hz",
          springs_.unbalanced_frames, springs_.unbalanced_n));
    }
  }
  [[nodiscard]] SimulationState state() const override {
    SimulationState out{stepper_.state()};
    out.springs = springs_;
    return out;
  }

 private:
  /// The tool of a pass begins without deflection.
  void release() {
    springs_.lost_mj += springs_.spring_mj;
    springs_.spring_mj = 0;
    springs_.deflection_mm = springs_.bone_n = springs_.tool_mm_s = {};
    springs_.bone_n_s_mm = {};
  }

  [[nodiscard]] Vec3 deflection_mm() const { return Vec3(springs_.deflection_mm.data()); }

  /// Bound of the motion between two poses of the tool or, with the deflection as a lever, of the plan.
  [[nodiscard]] double bound_mm(const ToolPose& a, const ToolPose& b, double lever_mm) const {
    const double spin_mm =
        resolved_ ? std::abs(b.spin_angle_rad - a.spin_angle_rad) * scene().tool.profile.max_radius_mm() : 0;
    return motion_bound_mm(a, b, scene().tool.reach_mm + lever_mm) + spin_mm;
  }

  static ToolPose deflected(const ToolPose& plan, const Vec3& deflection_mm) {
    ToolPose out = plan;
    out.position_mm += plan.orientation * deflection_mm;
    return out;
  }

  /// Finds the deflection at the end of a part of a frame, and cuts.
  Deflection cut_part(const FrameMotion& plan, int i, int parts) {
    const Mat3 tool_from_bone = plan.pose.orientation.toRotationMatrix().transpose();
    const Vec3 before_mm = deflection_mm();
    const SpringBalance balance{.stiffness_n_mm = settings_.stiffness_n_mm,
                                .damping_n_s_mm = settings_.damping_n_s_mm,
                                .planned_mm = tool_from_bone * (plan.pose.position_mm - plan.before.position_mm),
                                .duration_s = plan.duration_s,
                                .most_mm = step_mm_ - bound_mm(plan.before, plan.pose, before_mm.norm()),
                                .least_mm = loss_mm_};
    const auto motion = [&](const Vec3& mm) {
      FrameMotion out = plan;
      out.before = deflected(plan.before, before_mm);
      out.pose = deflected(plan.pose, mm);
      return out;
    };
    const Deflection found = balanced_deflection(
        balance, [&](const std::vector<Vec3>& tried) { return bone_forces(tried, motion); }, springs_);
    const SubstepSums cut = stepper_.add_part(motion(found.mm), i, parts);
    add_spring_energies(balance, found,
                        {.bone_n = force_of(cut),
                         .torque_nmm = torque_of(cut),
                         .tilt_rad = tool_from_bone * rotation_vector(plan.before.orientation, plan.pose.orientation),
                         .spin_rad = plan.pose.spin_angle_rad - plan.before.spin_angle_rad},
                        springs_);
    return found;
  }

  /// Mean forces of the bone in a part of a frame that ends at these deflections, T. One call of the engine.
  template <class MotionOf>
  std::vector<Vec3> bone_forces(const std::vector<Vec3>& deflections_mm, const MotionOf& motion_of) {
    std::vector<FrameMotion> motions;
    std::vector<std::optional<SlowTrial>> slow;
    for (const Vec3& mm : deflections_mm) {
      const FrameMotion motion = motion_of(mm);
      slow.push_back(slow_trial(bound_mm(motion.before, motion.pose, 0), loss_mm_));
      if (!slow.back()) {
        motions.push_back(motion);
      } else {
        motions.push_back(prolonged(motion, slow.back()->first));
        motions.push_back(prolonged(motion, slow.back()->second));
      }
    }
    const std::vector<SubstepSums> sums = stepper_.evaluate(motions);
    std::vector<Vec3> out;
    std::size_t next = 0;
    for (const std::optional<SlowTrial>& times : slow) {
      const Vec3 force = force_of(sums[next++]);
      out.push_back(
          times ? Vec3((times->second * force_of(sums[next++]) - times->first * force) / (times->second - times->first))
                : force);
    }
    return out;
  }

  const ComplianceSettings& settings_;
  FrameStepper& stepper_;
  Diagnostics& report_;
  double frame_s_;
  bool resolved_;
  double step_mm_;  ///< the longest of a substep
  double loss_mm_;  ///< advance of a smallest loss
  SpringState springs_;
};

}  // namespace

std::unique_ptr<Feed> spring_feed(const SimulationInput& scene, FrameStepper& stepper, Diagnostics& report) {
  return std::make_unique<SpringFeed>(scene, stepper, report);
}

}  // namespace reamsim
