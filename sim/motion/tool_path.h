#pragma once

#include <vector>

#include "sim/motion/motion.h"

namespace reamsim {

/// Rotation vector (axis times angle, at most π) that takes orientation `a` to `b`, in B.
Vec3 rotation_vector(const Quat& a, const Quat& b);

/// Bound of the motion from pose `a` to `b` of any point within `reach_mm` of the tool's origin, mm. Without the spin,
/// which does not move an envelope of revolution.
double motion_bound_mm(const ToolPose& a, const ToolPose& b, double reach_mm);

/// A path of the tool, parametrized by the accumulated motion_bound_mm().
class ToolPath {
 public:
  /// `poses` must outlive the path, and is not empty.
  ToolPath(const std::vector<ToolPose>& poses, double reach_mm);

  [[nodiscard]] double length_mm() const { return ends_mm_.back(); }
  /// The frame at the end of the segment with `at_mm`.
  [[nodiscard]] std::size_t frame_at(double at_mm) const;
  [[nodiscard]] ToolPose pose_at(double at_mm) const;

 private:
  const std::vector<ToolPose>& poses_;
  std::vector<double> ends_mm_;  ///< by frame
};

/// A pose on a path.
struct PathSample {
  ToolPose pose;
  std::size_t frame = 0;  ///< the frame at the pose or at the end of its segment
};

/// Poses along a motion, with motion_bound_mm() of at most `step_mm` between two of them. They include the poses where
/// the tool stops or reverses, such as the deepest one.
std::vector<PathSample> sample_path(const std::vector<ToolPose>& poses, double reach_mm, double step_mm);

}  // namespace reamsim
