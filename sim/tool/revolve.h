#pragma once

#include "sim/mesh/triangle_mesh.h"
#include "sim/tool/profile.h"

namespace reamsim {

/// Turns a profile about z into a closed mesh (mm, frame T) with `segments` vertices per ring, the first at angle 0.
/// The vertices lie on the surface of revolution, so that flat facets stay within r·(1 − cos(π/segments)) of it.
/// Profile points on the axis become one vertex; edges on the axis give no triangle.
TriangleMesh revolve(const Profile& profile, int segments);

/// Vertices per ring that keep a facet within `sagitta_mm` of a circle of `radius_mm`; at least 32, a multiple of 4.
int segments_for_sagitta(double radius_mm, double sagitta_mm);

}  // namespace reamsim
