// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/mesh/triangle_mesh.h"
#include "sim/tool/profile.h"

namespace reamsim {

/// Revolves a profile about z to a closed mesh (mm, frame T) with `segments` vertices per ring, the first at angle 0.
/// Vertices lie on the surface of revolution, and facets within r·(1 − cos(π/segments)) of it. A profile point on the
/// axis becomes one vertex; an edge on the axis yields no triangle.
TriangleMesh revolve(const Profile& profile, int segments);

/// Vertices per ring for a sagitta of at most `sagitta_mm` at `radius_mm`; at least 32, a multiple of 4.
int segments_for_sagitta(double radius_mm, double sagitta_mm);

}  // namespace reamsim
