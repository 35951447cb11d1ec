// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/bone/bone.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// The articular face of the parametric glenoid. Balls remove bone: one with the radius of the native face and, for
/// wear, one with that of the humeral head. Its figures therefore have closed forms (docs/glenoid.md). Anatomical
/// coordinates, mm, from the centre of the native face: (lateral, superior, anterior). Lateral is the Friedman axis.
struct GlenoidFace {
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
  /// Axis of the native face: lateral, rotated by version (posterior positive) and inclination.
  [[nodiscard]] Vec3 native_normal() const { return face_from_anatomy.row(0); }

  std::vector<Ball> balls;  ///< the native face first, then the worn one
  Mat3 face_from_anatomy;   ///< rows: normal, superior and anterior of the native face
  /// The native axis; of a biconcave face across the line from rim to rim, the intermediate glenoid (Rouleau et al.
  /// 2010).
  Vec3 normal;
  Vec3 center_mm = Vec3::Zero();  ///< the intersection of the Friedman axis and the face
  std::optional<Biconcavity> biconcavity;
};

/// Version (retroversion positive) and inclination (superior positive) of a direction in anatomical coordinates, rad.
double version_of(const Vec3& direction);
double inclination_of(const Vec3& direction);

/// The parametric glenoid as an implicit solid: a pear-shaped, concave face with an anterior notch and a rounded rim,
/// the vault that narrows to the neck, and the stumps of coracoid, spine, blade and lateral border. All proportions
/// follow from width, height and radius of the face and from the depth of the vault. Anatomical coordinates of
/// GlenoidFace, on a right bone a mirror image of B.
class GlenoidShape {
 public:
  explicit GlenoidShape(const PhantomSettings& settings);

  static constexpr double kMaxSlope = 2.5;  ///< upper bound of the slope of solid()

  /// Negative inside the bone, near its surface about the distance from it. The stumps extend beyond medial_end_mm().
  [[nodiscard]] double solid(const Vec3& point) const;
  [[nodiscard]] const GlenoidFace& face() const { return face_; }
  /// The edge of the face before the rim is rounded, in order, mm. `rounded`: the middle of the rounded edge, on the
  /// surface, where face and wall are blended in equal parts.
  [[nodiscard]] std::vector<Vec3> rim_mm(bool rounded = false) const;
  /// The stumps end at this lateral coordinate, mm.
  [[nodiscard]] double medial_end_mm() const { return medial_end_mm_; }
  /// Bounding box of the solid up to the medial end.
  [[nodiscard]] const Aabb& bounds_mm() const { return bounds_mm_; }

 private:
  /// A rod between two points whose radius varies linearly.
  struct Rod {
    Rod() = default;
    Rod(const Vec3& from, double radius_from, const Vec3& to, double radius_to)
        : a(from),
          axis(to - from),
          length2(axis.squaredNorm()),
          radius_a(radius_from),
          growth(radius_to - radius_from) {}

    Vec3 a = Vec3::Zero(), axis = Vec3::Zero();
    double length2 = 1, radius_a = 0, growth = 0;

    [[nodiscard]] double distance(const Vec3& point) const {
      const Vec3 from_a = point - a;
      const double fraction = std::clamp(from_a.dot(axis) / length2, 0.0, 1.0);
      return (from_a - fraction * axis).norm() - (radius_a + fraction * growth);
    }
  };

  void place_stumps(double face_radius_mm);
  [[nodiscard]] Vec3 in_face(const Vec3& point) const;
  /// q: in the frame of the face.
  [[nodiscard]] double vault(const Vec3& q) const;
  [[nodiscard]] double rim_blend_mm(const Vec3& q) const;
  /// A value that is at least `limit` may be replaced by `limit`.
  [[nodiscard]] double stumps(const Vec3& point, double limit = std::numeric_limits<double>::infinity()) const;
  [[nodiscard]] double coracoid(const Vec3& point) const;
  [[nodiscard]] double body(const Vec3& point) const;
  [[nodiscard]] double blade(const Vec3& point) const;

  GlenoidFace face_;
  double half_width_mm_;
  double height_mm_;
  double vault_depth_mm_;
  double rim_mm_;  ///< width of the rim's rounding
  double posteroinferior_rim_mm_;
  double medial_end_mm_ = 0;
  double body_end_mm_ = 0;
  std::vector<Rod> coracoid_;
  Aabb coracoid_mm_ = Aabb::none();
  Rod border_;
  Rod crest_;
  std::vector<Vec2> blade_outline_;
  std::vector<Vec2> spine_outline_;
  Aabb bounds_mm_;
};

/// The bone of bone_from_phantom() for a glenoid, on a given lattice and clipped by it. Throws likewise.
FilledVoxmap sample_glenoid(const BoneSettings& settings, const VoxelGrid& grid);

/// Density in g/cm³ at a point of B in mm; kAir without bone. Called from several threads at once.
using DensityField = std::function<double(const Vec3&)>;
inline constexpr double kAir = -1;

/// Whether a ball around a point of B with a radius in mm certainly contains no bone.
using AirTest = std::function<bool(const Vec3&, double)>;

struct PartialVoxel {
  double fraction = 0;       ///< of bone, 0…1
  double density_g_cm3 = 0;  ///< of that bone; not used where the centre is bone
};
/// Describes the voxel around a point of B, mm. Called for voxels at the surface only, from several threads at once.
using PartialField = std::function<PartialVoxel(const Vec3& center_mm, bool center_is_bone)>;

/// Samples the density at the centres of the voxels, in the frame "phantom", except in bricks for which `all_air` is
/// true. Without `partial` the voxels at the surface are whole. The result does not depend on the threads.
FilledVoxmap sample_phantom(
    const VoxelGrid& grid, const DensitySettings& density, const DensityField& field, const PartialField& partial = {},
    const AirTest& all_air = [](const Vec3&, double) { return false; });

/// Throws the InputError of a length in bone.phantom.
[[noreturn]] void fail_phantom(const std::string& key, double found_mm, const std::string& expected);

/// Smooth noise in −1…1: hashed integers on a unit lattice, blended with a quintic. The same on every machine.
double value_noise(const Vec3& point, std::uint32_t seed);

}  // namespace reamsim
