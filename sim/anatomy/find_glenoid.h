// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "sim/anatomy/face_surface.h"
#include "sim/base/error.h"
#include "sim/bone/bone.h"

namespace reamsim {

/// Whether there is air on any of the six sides of a voxel, as outside the lattice.
bool has_air_beside(const Voxmap& voxmap, const Vec3i& voxel);

/// Bone in a sphere around a point, on both sides of a plane through it.
struct NearbyBone {
  double radius_mm = 0;
  double ahead_mm3 = 0;  ///< on the side of the plane's normal
  double behind_mm3 = 0;
  Vec3 outward = Vec3::Zero();  ///< unit vector from the centroid of the bone to the point; 0 where they coincide
};
NearbyBone nearby_bone(const Voxmap& voxmap, const Vec3& point_mm, const Vec3& normal, double radius_mm);

/// The bone as a continuous field, for lines through it. The view must outlive the probe.
class BoneProbe {
 public:
  explicit BoneProbe(const BoneView& bone) : bone_(bone) {}

  /// The fraction of bone at a point of B, interpolated between the centres of voxels, 0…1.
  [[nodiscard]] double fraction(const Vec3& point_mm) const;
  /// Distance along `direction`, a unit vector, at which a line from `from_mm` enters bone: the fraction passes a half.
  /// nullopt where it does not within `most_mm`, or starts inside bone.
  [[nodiscard]] std::optional<double> distance_to_bone(const Vec3& from_mm, const Vec3& direction,
                                                       double most_mm) const {
    return crossing(from_mm, direction, most_mm, true);
  }
  /// The same for leaving bone; nullopt where the line starts outside.
  [[nodiscard]] std::optional<double> distance_to_air(const Vec3& from_mm, const Vec3& direction,
                                                      double most_mm) const {
    return crossing(from_mm, direction, most_mm, false);
  }
  [[nodiscard]] double voxel_mm() const { return bone_.voxmap.grid.voxel_mm; }

 private:
  [[nodiscard]] std::optional<double> crossing(const Vec3& from_mm, const Vec3& direction, double most_mm,
                                               bool into_bone) const;

  BoneView bone_;
};

/// The outline of an articular face in its plane: two circles and their outer tangents, a pear (Huysmans et al. 2006,
/// Journal of Shoulder and Elbow Surgery 15, 759–763: the inferior part of the glenoid is a circle).
struct PearOutline {
  Vec2 center_mm = Vec2::Zero();  ///< the middle of the height, on the long axis
  double axis_rad = 0;            ///< direction from the larger circle to the smaller, from +x of the plane
  double height_mm = 0;           ///< along that direction
  double radius_mm = 0;           ///< of the larger circle; half of the width
  double upper_ratio = 0;         ///< radius of the smaller circle over that of the larger, 0.5…0.95

  /// Distance of a point from the outline, negative inside, mm. `axis`: axis(), which many points share.
  [[nodiscard]] double distance_mm(const Vec2& point_mm) const { return distance_mm(point_mm, axis()); }
  [[nodiscard]] double distance_mm(const Vec2& point_mm, const Vec2& axis) const;
  [[nodiscard]] Vec2 axis() const { return {std::cos(axis_rad), std::sin(axis_rad)}; }
};

/// An outline fitted robustly to points of a rim.
struct OutlineFit {
  PearOutline outline;
  double inlier_fraction = 0;  ///< points within kRimInlier_mm
  double rms_mm = 0;           ///< of these
};

inline constexpr double kRimInlier_mm = 1.5;

/// Least squares with Tukey's weights, by Levenberg and Marquardt. nullopt for fewer than 12 points.
std::optional<OutlineFit> fit_pear(const std::vector<Vec2>& rim_mm);

/// Where the normal of a face comes from.
enum class FaceNormal { sphere, plane, rim };

/// An articular face in the course of a search, and the better frame that follows from its outline and surface.
struct FittedFace {
  Rigid bone_from_face = Rigid::Identity();  ///< origin on the surface, +z out of the bone
  Rigid old_frame = Rigid::Identity();       ///< of rim and fit, one turn earlier
  std::vector<Vec3> rim_mm;                  ///< where the surface turns away, in the order of the directions
  int directions = 0;  ///< that were walked; the others have no edge, as at the base of the coracoid
  OutlineFit fit;
  FaceSurface surface;
  FaceNormal normal = FaceNormal::sphere;

  /// The fraction of all directions with a rim on the outline.
  [[nodiscard]] double rim_fraction() const {
    return fit.inlier_fraction * static_cast<double>(rim_mm.size()) / directions;
  }
  /// The points of the rim that lie near the outline.
  [[nodiscard]] std::vector<Vec3> rim_at_outline_mm() const;
  /// The long axis of the outline in B, towards its narrow end.
  [[nodiscard]] Vec3 along() const {
    const Vec2 axis = fit.outline.axis();
    return old_frame.linear() * Vec3(axis.x(), axis.y(), 0);
  }
};

struct FitEffort {
  int directions = 0;  ///< of the walks
  int turns = 0;
};
inline constexpr FitEffort kCoarseEffort{24, 4}, kFineEffort{90, 12};

/// Fits the face at a start on the surface, +z out of the bone: walks to the rim, fits outline and surface, and moves
/// the frame to the middle of the face, until it rests or the turns are over. nullopt where there is no face.
std::optional<FittedFace> fit_face(const BoneProbe& probe, const Rigid& start, const FitEffort& effort);

/// How much a face is that of a joint, at most 1: the fraction of its rim, less for a rim that is no pear, a slim face,
/// or more than one surface. −1: too small, too large, or convex.
double face_score(const FittedFace& face);

struct FoundGlenoid {
  GlenoidFrame frame;               ///< origin on the surface, +z out of the face, +y superior
  std::vector<Vec3> rim_mm;         ///< B, in order round the face
  std::string sentence;             ///< for the console: centre, normal, size and residuals
  std::vector<std::string> doubts;  ///< what makes the frame uncertain, a sentence each
};

/// Finds the face round `settings.near_mm`, which lies within about 8 mm of its centre. The centre is the middle of the
/// pear's height on its long axis, moved to the surface along the normal. The normal points to the centre of the
/// sphere; for a face that is no single surface it is that of the plane through the rim, the intermediate glenoid
/// (Rouleau et al. 2010). Superior is that of the settings; else the long axis towards +z of a scan, else towards its
/// narrow end. Throws InputError: no bone near the point, no face round it.
FoundGlenoid find_glenoid(const BoneView& bone, const GlenoidSettings& settings, BodySide side);

/// A place on a bone where a glenoid may be. B.
struct FacePlace {
  Vec3 center_mm = Vec3::Zero();  ///< on the surface
  Vec3 normal = Vec3::UnitZ();    ///< out of the bone
  double height_mm = 0, width_mm = 0;
  double confidence = 0;  ///< 0…1: how much the place resembles a glenoid
};

/// What a face is as the place of a glenoid. The confidence is face_score() times the square root of factors that fall
/// from 1 to 0 for a height outside 26…46 mm (0 at 20 and 52), a width outside 19…36 mm (14, 42) and a vault below 15
/// mm (10).
FacePlace place_of(const BoneProbe& probe, const FittedFace& face);

/// The place at a frame on the surface, fitted finely; nullopt where there is no face.
std::optional<FacePlace> place_at(const BoneView& bone, const Rigid& bone_from_face);

/// Searches the whole surface of a bone for faces that resemble a glenoid (place_of()), which the acromion and the
/// fossae of the scapula do not. Starts every 5 mm are fitted coarsely; those that are faces are fitted finely. The
/// best come first. Voxels of about 1 mm suffice.
std::vector<FacePlace> search_faces(const BoneView& bone);

/// Compares the glenoid frame of a bone, if any, with the unreamed bone; not that of a phantom. Mistakes: a centre more
/// than 10 mm from the surface, a normal into the bone. Warnings, because a specimen may be scanned in any position: in
/// LPS a left glenoid does not face +x, or superior is not +z. `settings` determine the keys in the messages.
void check_glenoid_frame(const Bone& bone, const BoneSettings& settings, MistakeList& mistakes, Diagnostics& report);

}  // namespace reamsim
