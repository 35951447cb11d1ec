#pragma once

#include <optional>

#include "sim/bone/ct/aligned_image.h"

namespace reamsim::ct {

/// The head of the humerus in a scan, and the sphere that cuts it off through the joint gap. LPS, mm.
struct HumeralHead {
  Vec3 center_mm = Vec3::Zero();
  double radius_mm = 0;          ///< of the sphere that fits its surface
  double rms_mm = 0;             ///< of the points of the surface near that sphere
  double cut_radius_mm = 0;      ///< through the least radiodensity between head and glenoid
  double touching_fraction = 0;  ///< of the directions towards the glenoid: no voxel of the gap is below the threshold
};

/// Finds the head next to a point near the centre of the glenoid's face. Surface points vote for centres along their
/// inward normals (Ballard 1981, Pattern Recognition 13, 111–122: the generalized Hough transform); a sphere is then
/// fitted to those that face away from the centre, and the cut is chosen by the mean radiodensity over spheres round
/// it. nullopt where no sphere of 16 to 32 mm radius is next to the point.
std::optional<HumeralHead> find_humeral_head(const AlignedImage& hu, double threshold_hu, const Vec3& near_mm);

}  // namespace reamsim::ct
