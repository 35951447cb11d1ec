#pragma once

#include <vector>

#include "sim/bone/glenoid_face.h"

namespace reamsim {

/// The parametric glenoid as an implicit solid: a pear-shaped, concave face with an anterior notch and a rounded rim,
/// the vault that narrows to the neck, and the stumps of coracoid, spine, blade and lateral border. Wear takes from it;
/// a dysplastic one (Walch C) has its posteroinferior rim rounded off.
///
/// Anatomical coordinates of GlenoidFace, mm: (lateral, superior, anterior). They are a mirror image of B
/// on a right bone, so that one shape serves both sides. Proportions: width and height of the face, depth of the vault
/// and radius of the face come from the scenario; the rest follows them.
class GlenoidShape {
 public:
  explicit GlenoidShape(const PhantomSettings& settings);

  /// Changes of solid() per mm stay below this.
  static constexpr double kMaxSlope = 2.5;

  /// Negative inside the bone, about the distance to its surface near it. The stumps go on beyond medial_end_mm().
  [[nodiscard]] double solid(const Vec3& point) const;
  [[nodiscard]] const GlenoidFace& face() const { return face_; }
  /// The edge of the face before the rim is rounded, in order round it, mm.
  [[nodiscard]] std::vector<Vec3> rim_mm() const;
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
  [[nodiscard]] double rim_blend_mm(const Vec3& in_face) const;
  [[nodiscard]] double stumps(const Vec3& point) const;
  [[nodiscard]] double blade(const Vec3& point) const;
  [[nodiscard]] double spine(const Vec3& point) const;

  GlenoidFace face_;
  double half_width_mm_;
  double height_mm_;
  double face_radius_mm_;
  double vault_depth_mm_;
  double rim_mm_;  ///< width over which the rim is rounded
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
