// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

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

  /// Upper radius of the pear-shaped outline over the lower one, which is half the width.
  static constexpr double kUpperRadiusRatio = 0.68;

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
  [[nodiscard]] const Biconcavity* biconcavity() const { return biconcave_ ? &biconcavity_ : nullptr; }

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
  Biconcavity biconcavity_;
  bool biconcave_ = false;
};

/// Version (retroversion positive) and inclination (superior positive) of a direction in anatomical coordinates, rad.
double version_of(const Vec3& direction);
double inclination_of(const Vec3& direction);

}  // namespace reamsim
