// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "sim/run/balance.h"
#include "sim/run/feed.h"
#include "sim/tool/tool_path.h"

namespace reamsim {

namespace {

constexpr double kSpringTolerance = 1e-3;  ///< of the force; what is missing does not add up over frames
constexpr double kForceFloor_n = 1e-6;     ///< beside it
constexpr int kMostTrials = 40;
/// Resistance is measured over this part of the tool's displacement.
constexpr double kDifference = 0.25;

struct Trial {
  Vec3 mm = Vec3::Zero();
  Vec3 bone_n = Vec3::Zero();
  Vec3 excess_n = Vec3::Zero();  ///< of spring and damper over the bone
};

class SpringSolver {
 public:
  SpringSolver(const SpringBalance& balance, const BoneForces& bone, const SpringState& before)
      : b_(balance), bone_(bone), before_mm_(before.deflection_mm), slope_(before.bone_n_s_mm / balance.duration_s) {
    own_n_mm_ = b_.stiffness_n_mm + Vec3::Constant(b_.damping_n_s_mm / b_.duration_s);
  }

  Deflection solve(const SpringState& before) {
    best_ = tried({first_guess(before)})[0];
    if (slope_.isZero() && !best_.bone_n.isZero() && !is_balanced()) rescue({});
    int failures = 0;
    while (!is_balanced() && evaluations_ < kMostTrials && failures < 2) {
      const Vec3 step = bounded(best_.mm + newton_step()) - best_.mm;
      if (step.norm() <= tiny_mm()) {
        limited_ = newton_step().norm() > tiny_mm();
        break;
      }
      const Trial from = best_, to = tried({from.mm + step})[0];
      const double before_n = from.excess_n.norm(), after_n = to.excess_n.norm();
      learn(from, to);
      if (after_n < before_n) best_ = to;
      if (after_n <= 0.5 * before_n) {
        failures = 0;
      } else {
        failures = rescue(step) || after_n < 0.9 * before_n ? 0 : failures + 1;
      }
    }
    return result();
  }

 private:
  [[nodiscard]] double tiny_mm() const { return 1e-3 * b_.least_mm; }

  std::vector<Trial> tried(const std::vector<Vec3>& deflections) {
    ++evaluations_;
    const std::vector<Vec3> forces = bone_(deflections);
    std::vector<Trial> out;
    for (std::size_t i = 0; i < forces.size(); ++i) {
      Vec3 excess = b_.stiffness_n_mm.cwiseProduct(deflections[i]) +
                    b_.damping_n_s_mm / b_.duration_s * (deflections[i] - before_mm_) - forces[i];
      for (int axis = 0; axis < 3; ++axis) excess[axis] *= b_.is_rigid(axis) ? 0 : 1;
      out.push_back({deflections[i], forces[i], excess});
    }
    return out;
  }

  /// The derivative of the excess; 1 along rigid axes.
  [[nodiscard]] Mat3 jacobian() const {
    Mat3 out = slope_ + Mat3(own_n_mm_.asDiagonal());
    for (int axis = 0; axis < 3; ++axis) {
      if (!b_.is_rigid(axis)) continue;
      out.row(axis).setZero();
      out.col(axis).setZero();
      out(axis, axis) = 1;
    }
    return out;
  }

  /// The step that `slope_` suggests; with springs alone where that has no meaning.
  [[nodiscard]] Vec3 newton_step() const {
    const Vec3 step = -jacobian().partialPivLu().solve(best_.excess_n);
    if (step.allFinite()) return step;
    return -best_.excess_n.cwiseQuotient(own_n_mm_);
  }

  [[nodiscard]] Vec3 bounded(const Vec3& mm) const {
    const Vec3 change = mm - before_mm_;
    const double length = change.norm();
    return length <= b_.most_mm ? mm : Vec3(before_mm_ + b_.most_mm / length * change);
  }

  /// The balance if the bone resists as in the substep before: with its force there and the difference of velocities.
  [[nodiscard]] Vec3 first_guess(const SpringState& before) const {
    const Vec3 same_advance = before_mm_ + before.tool_mm_s * b_.duration_s - b_.planned_mm;
    Vec3 right = before.bone_n + slope_ * same_advance + b_.damping_n_s_mm / b_.duration_s * before_mm_;
    for (int axis = 0; axis < 3; ++axis) right[axis] *= b_.is_rigid(axis) ? 0 : 1;
    const Vec3 guess = jacobian().partialPivLu().solve(right);
    return bounded(guess.allFinite() ? guess : before_mm_);
  }

  void learn(const Trial& from, const Trial& to) {
    const Vec3 step = to.mm - from.mm;
    slope_ += (from.bone_n - to.bone_n - slope_ * step) * step.transpose() / step.squaredNorm();
  }

  /// Measures the resistance at the best point and tries shorter steps. Returns whether one of them is better.
  bool rescue(const std::optional<Vec3>& step) {
    const double size_mm = std::max(kDifference * (b_.planned_mm + best_.mm - before_mm_).norm(), 0.1 * b_.least_mm);
    std::vector<Vec3> trials;
    std::vector<int> axes;
    for (int axis = 0; axis < 3; ++axis) {
      if (b_.is_rigid(axis)) continue;
      // Towards the balance: the bone resists on one side only.
      const double sign = best_.excess_n[axis] > 0 ? -1 : 1;
      axes.push_back(axis);
      trials.push_back(best_.mm + sign * size_mm * Vec3::Unit(axis));
    }
    constexpr int kShorter = 6;
    for (int i = 1; step && i <= kShorter; ++i) trials.push_back(best_.mm + std::pow(0.5, i) * *step);
    const std::vector<Trial> points = tried(trials);
    const Trial center = best_;
    for (std::size_t i = 0; i < axes.size(); ++i) {
      slope_.col(axes[i]) = (center.bone_n - points[i].bone_n) / (points[i].mm - center.mm)[axes[i]];
    }
    for (const Trial& p : points) {
      if (p.excess_n.norm() < best_.excess_n.norm()) best_ = p;
    }
    return best_.excess_n.norm() < 0.9 * center.excess_n.norm();
  }

  [[nodiscard]] bool is_balanced() const {
    const double force = std::max(best_.bone_n.norm(), b_.stiffness_n_mm.cwiseProduct(best_.mm).norm());
    return best_.excess_n.norm() <= kSpringTolerance * force + kForceFloor_n;
  }

  [[nodiscard]] Deflection result() const {
    Deflection out{.mm = best_.mm, .bone_n = best_.bone_n, .limited = limited_, .evaluations = evaluations_};
    // Bone that has been left is met again with another resistance.
    out.bone_n_s_mm = best_.bone_n.isZero() ? Mat3::Zero() : Mat3(slope_ * b_.duration_s);
    out.missing_n = best_.excess_n.norm();
    constexpr double kNoted = 0.01;
    out.balanced = limited_ || out.missing_n <= kNoted * best_.bone_n.norm() + kForceFloor_n ||
                   newton_step().norm() <= b_.least_mm;
    return out;
  }

  const SpringBalance& b_;
  const BoneForces& bone_;
  Vec3 before_mm_;
  Mat3 slope_;  ///< −∂F/∂d, N/mm
  Vec3 own_n_mm_;
  Trial best_;
  int evaluations_ = 0;
  bool limited_ = false;
};

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
        resolved_(is_moved_by_spin(scene.scenario, scene.tool)),
        step_mm_(scene.scenario.engine.max_step_voxels * scene.bone.voxmap->grid.voxel_mm),
        loss_mm_(smallest_advance_mm(scene.bone.voxmap->grid.voxel_mm)) {}

  void start() override {
    // The tool of a pass begins without deflection.
    springs_.lost_mj += springs_.spring_mj;
    springs_.spring_mj = 0;
    springs_.deflection_mm = springs_.bone_n = springs_.tool_mm_s = Vec3::Zero();
    springs_.bone_n_s_mm.setZero();
    FrameMotion rest = planned_motion(scene().motion, scene().motion.first_frame);
    rest.deflection_mm = Vec3::Zero();
    stepper_.start(rest);
  }
  void resume(const SimulationState& from) override { springs_ = from.springs; }

  void add(std::int64_t frame) override {
    const ToolPose begin = scene().motion.pose_of(frame - 1), end = scene().motion.pose_of(frame);
    const double planned_mm = bound_mm(begin, end, springs_.deflection_mm.norm());
    const int parts = std::max(1, static_cast<int>(std::ceil(planned_mm / ((1 - kStepOfDeflection) * step_mm_))));
    bool limited = false, balanced = true;
    for (int i = 0; i < parts; ++i) {
      const FrameMotion plan{.frame = frame,
                             .before = interpolate(begin, end, static_cast<double>(i) / parts),
                             .pose = interpolate(begin, end, static_cast<double>(i + 1) / parts),
                             .duration_s = scene().motion.frame_s() / parts,
                             .time_s = static_cast<double>(frame) * scene().motion.frame_s()};
      const Deflection found = cut_part(plan, i, parts);
      limited |= found.limited;
      balanced &= found.balanced;
    }
    springs_.limited_frames += limited ? 1 : 0;
    springs_.unbalanced_frames += balanced ? 0 : 1;
    stepper_.set_deflection(springs_.deflection_mm);
  }
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

  Deflection cut_part(const FrameMotion& plan, int i, int parts) {
    const Mat3 tool_from_bone = plan.pose.orientation.toRotationMatrix().transpose();
    const Vec3 before_mm = springs_.deflection_mm;
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
  bool resolved_;
  double step_mm_;  ///< the longest of a substep
  double loss_mm_;  ///< advance of a smallest loss
  SpringState springs_;
};

}  // namespace

Deflection balanced_deflection(const SpringBalance& balance, const BoneForces& bone, const SpringState& before) {
  return SpringSolver(balance, bone, before).solve(before);
}

void add_spring_energies(const SpringBalance& b, const Deflection& now, const PartWork& work, SpringState& state) {
  const Vec3 change = now.mm - state.deflection_mm, advance = b.planned_mm + change;
  Vec3 spring_n = -work.bone_n;  // on the tool
  double spring_mj = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (b.is_rigid(axis)) continue;
    const double k = b.stiffness_n_mm[axis], damper_n = b.damping_n_s_mm * change[axis] / b.duration_s;
    spring_n[axis] = -k * now.mm[axis] - damper_n;
    spring_mj += 0.5 * k * now.mm[axis] * now.mm[axis];
    state.damping_mj += damper_n * change[axis];
    state.lost_mj += 0.5 * k * change[axis] * change[axis];
  }
  state.spring_mj = spring_mj;
  state.carriage_mj += spring_n.dot(b.planned_mm) - (work.torque_nmm + now.mm.cross(work.bone_n)).dot(work.tilt_rad);
  state.spindle_work_mj += work.torque_nmm.z() * work.spin_rad;
  state.unbalanced_mj += (spring_n + work.bone_n).dot(advance);
  state.deflection_mm = now.mm;
  state.bone_n = now.bone_n;
  state.tool_mm_s = advance / b.duration_s;
  state.bone_n_s_mm = now.bone_n_s_mm;
  state.unbalanced_n = std::max(state.unbalanced_n, now.balanced || now.limited ? 0 : now.missing_n);
}

std::unique_ptr<Feed> spring_feed(const SimulationInput& scene, FrameStepper& stepper, Diagnostics& report) {
  return std::make_unique<SpringFeed>(scene, stepper, report);
}

}  // namespace reamsim
