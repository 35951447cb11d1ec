// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/mesh/triangle_mesh.h"
#include "sim/tool/profile.h"

namespace reamsim::assets {

// The shipped reamers in the tool frame T, mm. The origin of a spherical face is its apex, which the cannula removes.
// Sizes: assets/README.md.

/// Radius of the cannula that runs through every reamer, for a 2.5 mm guide pin.
inline constexpr double kCannulaRadiusMm = 1.25;
inline constexpr double kHemisphereRadiusMm = 14;
inline constexpr double kConvexCurvatureMm = 29;
inline constexpr double kConvexRadiusMm = 15;
inline constexpr double kFlatRadiusMm = 13.5;

/// Vertices per ring of the surfaces of revolution; facets lie within 3.6 µm of a 15 mm circle.
inline constexpr int kRingSegments = 144;
/// More, because the hemisphere is steep at its rim, where the sagitta of a facet matters most.
inline constexpr int kHemisphereSegments = 160;

Profile hemispherical_profile();
Profile convex_profile();
Profile flat_profile();

/// The closed envelope of a twist drill of 3.2 mm with a point of 118°; its tip is the origin.
Profile drill_profile();

/// The convex reamer with six spiral cutting edges and a chip slot through the head before each. The cutting edges lie
/// on the face of convex_profile(); between them the face is set back by up to 0.9 mm.
TriangleMesh convex_with_cutting_edges();

}  // namespace reamsim::assets
