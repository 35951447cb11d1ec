#pragma once

#include "sim/mesh/triangle_mesh.h"
#include "sim/tool/profile.h"

namespace reamsim::assets {

// The shipped reamers, in the tool frame T (mm; origin at the lowest point of the cutting surface on the spin axis, for
// a sphere its apex although the cannula bores it away; +z towards the drill). Sizes: assets/README.md.

/// Radius of the cannula that runs through every reamer, for a 2.5 mm guide pin.
inline constexpr double kCannulaRadiusMm = 1.25;
inline constexpr double kHemisphereRadiusMm = 14;
inline constexpr double kConvexCurvatureMm = 29;
inline constexpr double kConvexRadiusMm = 15;
inline constexpr double kFlatRadiusMm = 13.5;

/// Vertices per ring of the surfaces of revolution; facets lie within 3.6 µm of a 15 mm circle.
inline constexpr int kRingSegments = 144;
/// The hemisphere is steep at its rim, where a facet's whole sagitta counts.
inline constexpr int kHemisphereSegments = 160;

Profile hemispherical_profile();
Profile convex_profile();
Profile flat_profile();

/// The convex reamer with six spiral cutting lips and a chip slot through the head before each of them. Its lips lie on
/// the face of convex_profile(); between them the face is set back by up to 0.9 mm.
TriangleMesh convex_with_cutting_edges();

}  // namespace reamsim::assets
