#pragma once

#include <optional>
#include <vector>

#include "sim/base/geometry.h"

namespace reamsim {

/// The edge of a joint face, as a closed polygon over the plane through its points.
class FaceOutline {
 public:
  /// `rim_mm`: points of B in order round the face. `outward`: the side of the plane that lies outside the bone.
  /// Nothing for points on a line.
  static std::optional<FaceOutline> of(const std::vector<Vec3>& rim_mm, const Vec3& outward);

  /// The plane's frame: origin in the polygon's middle, +z out of the bone.
  [[nodiscard]] const Rigid& bone_from_outline() const { return bone_from_outline_; }
  /// Distance of a place in the plane from the polygon, mm; positive inside.
  [[nodiscard]] double inside_mm(const Vec2& place_mm) const;
  /// Box round the points, in the plane's frame.
  [[nodiscard]] const Aabb& box_mm() const { return box_mm_; }
  /// Of the largest circle round the middle that lies inside.
  [[nodiscard]] double inner_radius_mm() const { return inside_mm(Vec2::Zero()); }

 private:
  Rigid bone_from_outline_ = Rigid::Identity();
  std::vector<Vec2> corners_mm_;
  Aabb box_mm_;
};

}  // namespace reamsim
