// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <vector>

#include "sim/bone/glenoid_face.h"
#include "sim/bone/implicit.h"

namespace reamsim {

/// The parametric glenoid as an implicit solid: a pear-shaped, concave face with an anterior notch and a rounded rim,
/// the vault that narrows to the neck, and the stumps of coracoid, spine, blade and lateral border. Wear removes bone
/// from it; a dysplastic glenoid (Walch C) has a rounded posteroinferior rim.
///
/// Anatomical coordinates of GlenoidFace, mm: (lateral, superior, anterior). On a right bone they are a mirror image of
/// B, so that one shape describes both sides. All proportions follow from width, height and radius of the face and from
/// the depth of the vault.
class GlenoidShape {
 public:
  explicit GlenoidShape(const PhantomSettings& settings);

  /// Upper bound of the slope of solid().
  static constexpr double kMaxSlope = 2.5;

  /// Negative inside the bone, near its surface about the distance from it. The stumps extend beyond medial_end_mm().
  [[nodiscard]] double solid(const Vec3& point) const;
  [[nodiscard]] const GlenoidFace& face() const { return face_; }
  /// The edge of the face before the rim is rounded, in order, mm.
  [[nodiscard]] std::vector<Vec3> rim_mm() const;
  /// The middle of the rounded edge, on the surface, in order, mm: face and wall are blended there in equal parts.
  [[nodiscard]] std::vector<Vec3> rounded_rim_mm() const;
  /// The stumps end at this lateral coordinate, mm.
  [[nodiscard]] double medial_end_mm() const { return medial_end_mm_; }
  /// Bounding box of the solid up to the medial end.
  [[nodiscard]] const Aabb& bounds_mm() const { return bounds_mm_; }

 private:
  /// A rod between two points with a radius at each.
  struct Rod {
    Vec3 a;
    double radius_a = 0;
    Vec3 b;
    double radius_b = 0;

    [[nodiscard]] double distance(const Vec3& point) const {
      return implicit::tapered_rod(point, a, radius_a, b, radius_b);
    }
  };

  void place_stumps();
  [[nodiscard]] std::vector<Vec3> rim_where(const std::function<double(const Vec3&)>& rounding_mm) const;
  [[nodiscard]] Vec3 in_face(const Vec3& point) const;
  /// q: in the frame of the face.
  [[nodiscard]] double vault(const Vec3& q) const;
  [[nodiscard]] double rim_blend_mm(const Vec3& q) const;
  [[nodiscard]] double stumps(const Vec3& point) const;
  [[nodiscard]] double blade(const Vec3& point) const;
  [[nodiscard]] double spine(const Vec3& point) const;

  GlenoidFace face_;
  double half_width_mm_;
  double height_mm_;
  double face_radius_mm_;
  double vault_depth_mm_;
  double rim_mm_;  ///< width of the rim's rounding
  double posteroinferior_rim_mm_;
  double medial_end_mm_ = 0;
  std::vector<Rod> coracoid_;
  Rod border_;
  Rod crest_;
  std::vector<Vec2> blade_outline_;
  std::vector<Vec2> spine_outline_;
  Aabb bounds_mm_;
};

}  // namespace reamsim
