#pragma once

#include <optional>

#include "sim/base/mistake_list.h"
#include "sim/base/report.h"
#include "sim/bone/bone.h"

namespace reamsim {

/// The unreamed bone's surface where it is nearest to a point.
struct NearestSurface {
  Vec3 point_mm = Vec3::Zero();  ///< B
  double distance_mm = 0;        ///< to within a voxel
  bool inside = false;           ///< the point lies in the bone
};

/// nullopt without bone. Looks at few bricks beside those near the point.
std::optional<NearestSurface> nearest_surface(const Voxmap& voxmap, const Vec3& point_mm);

/// Bone near a point, before and behind a plane through it.
struct NearbyBone {
  double radius_mm = 0;
  double ahead_mm3 = 0;  ///< on the side of the plane's normal
  double behind_mm3 = 0;
  Vec3 outward = Vec3::Zero();  ///< from the bone's centroid to the point, of length 1; 0 where they coincide
};
NearbyBone nearby_bone(const Voxmap& voxmap, const Vec3& point_mm, const Vec3& normal, double radius_mm);

/// Holds a bone's glenoid frame against the unreamed bone. A frame that cannot be meant is a mistake: a centre further
/// than 10 mm from the surface, a normal that points into the bone. What a patient in the scanner's standard position
/// contradicts, and a specimen may not, is a warning: in LPS a left glenoid faces +x, and superior is +z.
/// `settings` say which keys the frame came from. Says nothing where there is no frame, or a phantom has its own.
void check_glenoid_frame(const Bone& bone, const BoneSettings& settings, MistakeList& mistakes, Report& report);

}  // namespace reamsim
