// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// The articular face of the parametric glenoid. Balls remove bone: one with the radius of the native face and, for
/// wear, one with that of the humeral head. All figures of the face therefore have closed forms (docs/glenoid.md).
///
/// Anatomical coordinates, mm, origin at the centre of the native face: (lateral, superior, anterior). Lateral is the
/// Friedman axis, from the trigonum spinae to the centre of the glenoid.
class GlenoidFace {
 public:
  explicit GlenoidFace(const PhantomSettings& settings);

  struct Ball {
    Vec3 center_mm;
    double radius_mm = 0;
  };
  /// Figures of a biconcave face (B2).
  struct Biconcavity {
    Vec3 ridge_mm;     ///< between the two parts, in the plane of axis and wear direction
    Vec3 neo_rim_mm;   ///< end of the neoglenoid in that plane
    Vec3 neo_normal;   ///< of the line from ridge to rim
    Vec3 wear;         ///< direction of the wear, across the native axis
    double angle = 0;  ///< between the normals of both parts at the ridge, radians
  };

  /// Exact distance below the face, positive into the bone.
  [[nodiscard]] double below_mm(const Vec3& point) const;
  /// The point at a depth below the face, at a position across the native axis; nullopt beside the balls.
  [[nodiscard]] std::optional<Vec3> at(double superior, double anterior, double below_mm = 0) const;
  /// The native face first, then the worn one.
  [[nodiscard]] const std::vector<Ball>& balls() const { return balls_; }
  /// Axis of the native face: lateral, rotated by version (posterior positive) and inclination.
  [[nodiscard]] Vec3 native_normal() const { return face_from_anatomy_.row(0); }
  /// Rows: normal, superior and anterior of the native face.
  [[nodiscard]] const Mat3& face_from_anatomy() const { return face_from_anatomy_; }
  /// Normal of the whole face: the native axis; for a biconcave face that of the line from rim to rim across both
  /// parts, the intermediate glenoid (Rouleau et al. 2010).
  [[nodiscard]] const Vec3& normal() const { return normal_; }
  /// The intersection of the Friedman axis and the face.
  [[nodiscard]] const Vec3& center_mm() const { return center_mm_; }
  /// B2 only; a null pointer otherwise.
  [[nodiscard]] const Biconcavity* biconcavity() const { return biconcavity_ ? &*biconcavity_ : nullptr; }

 private:
  [[nodiscard]] double outline_mm(double superior, double anterior) const;
  void wear_concentrically(const PhantomSettings& settings);
  void wear_one_side(const PhantomSettings& settings);
  void place_center();

  double half_width_mm_;
  double height_mm_;
  std::vector<Ball> balls_;
  Mat3 face_from_anatomy_;
  Vec3 normal_;
  Vec3 center_mm_ = Vec3::Zero();
  std::optional<Biconcavity> biconcavity_;
};

/// Version (retroversion positive) and inclination (superior positive) of a direction in anatomical coordinates, rad.
double version_of(const Vec3& direction);
double inclination_of(const Vec3& direction);

/// The parametric glenoid as an implicit solid: a pear-shaped, concave face with an anterior notch and a rounded rim,
/// the vault that narrows to the neck, and the stumps of coracoid, spine, blade and lateral border. Wear removes bone
/// from it; a dysplastic glenoid (Walch C) has a rounded posteroinferior rim. All proportions follow from width, height
/// and radius of the face and from the depth of the vault.
///
/// Anatomical coordinates of GlenoidFace. On a right bone they are a mirror image of B.
class GlenoidShape {
 public:
  explicit GlenoidShape(const PhantomSettings& settings);

  /// Upper bound of the slope of solid().
  static constexpr double kMaxSlope = 2.5;

  /// Negative inside the bone, near its surface about the distance from it. The stumps extend beyond medial_end_mm().
  [[nodiscard]] double solid(const Vec3& point) const;
  [[nodiscard]] const GlenoidFace& face() const { return face_; }
  /// The edge of the face before the rim is rounded, in order, mm.
  [[nodiscard]] std::vector<Vec3> rim_mm() const {
    return rim_where([](const Vec3&) { return 0.0; });
  }
  /// The middle of the rounded edge, on the surface, in order, mm: face and wall are blended there in equal parts.
  [[nodiscard]] std::vector<Vec3> rounded_rim_mm() const;
  /// The stumps end at this lateral coordinate, mm.
  [[nodiscard]] double medial_end_mm() const { return medial_end_mm_; }
  /// Bounding box of the solid up to the medial end.
  [[nodiscard]] const Aabb& bounds_mm() const { return bounds_mm_; }

 private:
  /// A rod between two points whose radius varies linearly.
  struct Rod {
    Vec3 a;
    double radius_a = 0;
    Vec3 b;
    double radius_b = 0;

    [[nodiscard]] double distance(const Vec3& point) const {
      const Vec3 axis = b - a;
      const double fraction = std::clamp((point - a).dot(axis) / axis.squaredNorm(), 0.0, 1.0);
      return (point - a - fraction * axis).norm() - (radius_a + fraction * (radius_b - radius_a));
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
