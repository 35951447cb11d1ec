#pragma once

#include <optional>
#include <string>

#include "sim/metrics/column_map.h"
#include "sim/metrics/face_outline.h"
#include "sim/metrics/face_surface.h"

namespace reamsim {

/// The joint face as it was before reaming, inside its rim.
struct NativeFace {
  std::optional<FaceSurface> surface;  ///< fitted to the face well inside its rim
  double area_mm2 = 0;                 ///< true area, along the surface, not its projection
  double reamed_mm2 = 0;               ///< the part of it that was reamed: from about half a voxel deep
};

/// Lines of sight on a face are this far apart at least, mm.
inline constexpr double kFacePitch_mm = 0.5;
/// The rim is rounded, and points on it are picked by hand: closer than this to the outline a face is not fitted to, mm
/// (no more than a quarter of the face's inner radius).
inline constexpr double kRimMargin_mm = 2.5;

/// Measures the unreamed surface within the outline, along the normal of the outline's plane. Heights are integrals of
/// fill, as in ColumnMap. Areas use the slope of a plane through the heights within kSlopeRadius_mm.
NativeFace measure_native_face(const ReamedBone& bone, const FaceOutline& outline);

}  // namespace reamsim
