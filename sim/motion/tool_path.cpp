#include "sim/motion/tool_path.h"

#include <algorithm>
#include <cmath>

namespace reamsim {

namespace {

/// Whether the tool stops or reverses at a pose.
bool reverses_at(const std::vector<ToolPose>& poses, std::size_t k) {
  const Vec3 before = poses[k].position_mm - poses[k - 1].position_mm;
  return k + 1 == poses.size() || before.dot(poses[k + 1].position_mm - poses[k].position_mm) <= 0;
}

}  // namespace

Vec3 rotation_vector(const Quat& a, const Quat& b) {
  const Eigen::AngleAxisd rotation(b * a.conjugate());
  const double angle = rotation.angle() > M_PI ? rotation.angle() - 2 * M_PI : rotation.angle();
  return angle * rotation.axis();
}

double motion_bound_mm(const ToolPose& a, const ToolPose& b, double reach_mm) {
  return (b.position_mm - a.position_mm).norm() + rotation_vector(a.orientation, b.orientation).norm() * reach_mm;
}

ToolPath::ToolPath(const std::vector<ToolPose>& poses, double reach_mm) : poses_(poses), ends_mm_(poses.size(), 0) {
  for (std::size_t k = 1; k < poses.size(); ++k) {
    ends_mm_[k] = ends_mm_[k - 1] + motion_bound_mm(poses[k - 1], poses[k], reach_mm);
  }
}

std::size_t ToolPath::frame_at(double at_mm) const {
  const auto end = std::ranges::lower_bound(ends_mm_, at_mm);
  return std::min(static_cast<std::size_t>(end - ends_mm_.begin()), poses_.size() - 1);
}

ToolPose ToolPath::pose_at(double at_mm) const {
  const std::size_t k = frame_at(at_mm);
  if (k == 0) return poses_[0];
  const double part_mm = ends_mm_[k] - ends_mm_[k - 1];
  const double t = part_mm > 0 ? (at_mm - ends_mm_[k - 1]) / part_mm : 1;
  return interpolate(poses_[k - 1], poses_[k], std::clamp(t, 0.0, 1.0));
}

std::vector<PathSample> sample_path(const std::vector<ToolPose>& poses, double reach_mm, double step_mm) {
  constexpr double kMinStep = 0.1;  // of a step: a tool that moves less dwells
  std::vector<PathSample> out{{poses.front(), 0}};
  const ToolPose* last = &poses.front();
  for (std::size_t k = 1; k < poses.size(); ++k) {
    const double bound_mm = motion_bound_mm(*last, poses[k], reach_mm);
    const auto parts = static_cast<std::int64_t>(std::ceil(bound_mm / step_mm));
    if (bound_mm < kMinStep * step_mm || (parts == 1 && !reverses_at(poses, k))) continue;
    for (std::int64_t i = 1; i < parts; ++i) {
      out.push_back({interpolate(*last, poses[k], static_cast<double>(i) / static_cast<double>(parts)), k});
    }
    out.push_back({poses[k], k});
    last = &poses[k];
  }
  return out;
}

}  // namespace reamsim
