#pragma once

#include <vector>

#include "sim/motion/motion.h"

namespace reamsim {

/// Rotation vector (axis times angle, at most π) that takes orientation `a` to `b`, in B.
Vec3 rotation_vector(const Quat& a, const Quat& b);

/// The bound of motion that substeps, predictions and plans share: no point within `reach_mm` of the tool's origin
/// moves further than this from pose `a` to pose `b`, mm. The spin is not in it: it does not move an envelope of
/// revolution.
double motion_bound_mm(const ToolPose& a, const ToolPose& b, double reach_mm);

/// A tool's motion as a length, mm, along which no point within `reach_mm` of its origin moves faster than 1.
class ToolPath {
 public:
  /// `poses` outlives the path, and has one pose at least.
  ToolPath(const std::vector<ToolPose>& poses, double reach_mm);

  [[nodiscard]] double length_mm() const { return ends_mm_.back(); }
  /// The frame that ends the part in which `at_mm` lies.
  [[nodiscard]] std::size_t frame_at(double at_mm) const;
  [[nodiscard]] ToolPose pose_at(double at_mm) const;

 private:
  const std::vector<ToolPose>& poses_;
  std::vector<double> ends_mm_;  ///< by frame
};

/// A pose of the tool on its path.
struct PathStop {
  ToolPose pose;
  std::size_t frame = 0;  ///< the frame that it belongs to, or leads to
};

/// Poses along a motion, from the first on: no point within `reach_mm` of the tool's origin moves further than
/// `step_mm` between two of them, and those are among them where the tool stops or turns back, as it does where it is
/// deepest.
std::vector<PathStop> stops_along(const std::vector<ToolPose>& poses, double reach_mm, double step_mm);

}  // namespace reamsim
