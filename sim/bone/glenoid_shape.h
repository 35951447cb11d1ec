#pragma once

#include <vector>

#include "sim/base/geometry.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// The parametric glenoid as an implicit solid: a pear-shaped, concave face with an anterior notch and a rounded rim,
/// the vault that narrows to the neck, and the stumps of coracoid, spine, blade and lateral border.
///
/// Anatomical coordinates, mm, origin at the face centre: (lateral, superior, anterior). They are a mirror image of B
/// on a right bone, so that one shape serves both sides. Proportions: width and height of the face, depth of the vault
/// and radius of the face come from the scenario; the rest follows them.
class GlenoidShape {
 public:
  explicit GlenoidShape(const PhantomSettings& settings);

  /// Changes of solid() per mm stay below this.
  static constexpr double kSteepest = 2.5;

  /// Negative inside the bone, about the distance to its surface near it. The stumps go on beyond medial_end_mm().
  [[nodiscard]] double solid(const Vec3& point) const;
  /// Distance below the face's sphere, positive into the bone: exact.
  [[nodiscard]] double below_face_mm(const Vec3& point) const;
  /// The way out of the face at its centre: lateral, turned by version (posterior positive) and inclination.
  [[nodiscard]] const Vec3& normal() const { return normal_; }
  /// The plane lateral = this value ends the stumps, mm.
  [[nodiscard]] double medial_end_mm() const { return medial_end_mm_; }
  /// Box that holds the solid up to the medial end.
  [[nodiscard]] const Aabb& bounds_mm() const { return bounds_mm_; }

 private:
  /// A rod between two points with a radius at each.
  struct Rod {
    Vec3 a;
    double radius_a = 0;
    Vec3 b;
    double radius_b = 0;
  };

  void place_stumps();
  [[nodiscard]] Vec3 in_face(const Vec3& point) const;
  [[nodiscard]] double vault(const Vec3& in_face) const;
  [[nodiscard]] double stumps(const Vec3& point) const;
  [[nodiscard]] double blade(const Vec3& point) const;
  [[nodiscard]] double spine(const Vec3& point) const;

  double half_width_mm_;
  double height_mm_;
  double face_radius_mm_;
  double vault_depth_mm_;
  double medial_end_mm_ = 0;
  Vec3 normal_;
  Mat3 face_from_anatomy_;  ///< rows: normal, superior and anterior of the face
  std::vector<Rod> coracoid_;
  Rod border_;
  Rod crest_;
  std::vector<Vec2> blade_outline_;
  std::vector<Vec2> spine_outline_;
  Aabb bounds_mm_;
};

}  // namespace reamsim
