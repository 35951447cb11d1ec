// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "sim/anatomy/face_surface.h"
#include "sim/base/geometry.h"
#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

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

  /// Distance of a point from the outline, negative inside, mm.
  [[nodiscard]] double distance_mm(const Vec2& point_mm) const;
  [[nodiscard]] Vec2 axis() const { return {std::cos(axis_rad), std::sin(axis_rad)}; }
};

/// An outline fitted robustly to points of a rim.
struct OutlineFit {
  PearOutline outline;
  double inlier_fraction = 0;  ///< points within kRimInlier_mm
  double rms_mm = 0;           ///< of these
};

inline constexpr double kRimInlier_mm = 1.5;

/// Least squares with Tukey's weights, by Levenberg and Marquardt; parts of the rim that are worn away do not count.
/// nullopt for fewer than 12 points.
std::optional<OutlineFit> fit_pear(const std::vector<Vec2>& rim_mm);

/// The edge of a face, found by walking over its surface.
struct RimWalk {
  std::vector<Vec3> rim_mm;  ///< where the surface turns away, in the order of the directions; in the walk's frame
  int directions = 0;        ///< that were walked; the others have no edge, as at the base of the coracoid
};

/// Walks over the surface from the origin of a frame on it, whose +z points out of the bone, in `directions` equal
/// steps of angle. A walk ends where the surface has fallen by 4 mm below its highest point or ends; the rim is its
/// corner, where it has turned to fall by 45 degrees. A walk has no rim where the surface rises steeply, or
/// extends beyond 35 mm.
RimWalk walk_to_rim(const BoneProbe& probe, const Rigid& bone_from_face, int directions);

/// Where the normal of a face comes from.
enum class FaceNormal { sphere, plane, rim };

/// An articular face in the course of a search: rim, outline and surface in one frame, and the better frame that
/// follows from them.
struct FittedFace {
  Rigid bone_from_face = Rigid::Identity();  ///< origin on the surface, +z out of the bone
  Rigid old_frame = Rigid::Identity();       ///< of walk and fit, one turn earlier
  RimWalk walk;
  OutlineFit fit;
  FaceSurface surface;
  FaceNormal normal = FaceNormal::sphere;

  /// The fraction of all directions with a rim on the outline.
  [[nodiscard]] double rim_fraction() const {
    return fit.inlier_fraction * static_cast<double>(walk.rim_mm.size()) / walk.directions;
  }
  /// The long axis of the outline in B, towards its narrow end.
  [[nodiscard]] Vec3 along() const {
    const Vec2 axis = fit.outline.axis();
    return old_frame.linear() * Vec3(axis.x(), axis.y(), 0);
  }
};

/// How finely a face is fitted.
struct FitEffort {
  int directions = 0;  ///< of the walks
  int turns = 0;
};
inline constexpr FitEffort kCoarseEffort{24, 4}, kFineEffort{90, 12};

/// Fits the face at a start on the surface whose +z points out of the bone: walks to the rim, fits outline and
/// surface, and moves the frame to the middle of the face, until the frame rests or the turns are over. nullopt where
/// there is no face.
std::optional<FittedFace> fit_face(const BoneProbe& probe, const Rigid& start, const FitEffort& effort);

/// The faces to which `fit(i)` leads for each of `count` items, in their order; computed in parallel.
std::vector<FittedFace> fit_all(std::size_t count, const std::function<std::optional<FittedFace>(std::size_t)>& fit);

/// How much a face is that of a joint, at most 1: the fraction of its rim, less for a rim that is no pear, a slim face,
/// or more than one surface. −1: too small, too large, or convex.
double face_score(const FittedFace& face);

/// The frame at a point with a normal as +z, rotated about it in any way.
Rigid frame_at(const Vec3& origin_mm, const Vec3& outward);

}  // namespace reamsim
