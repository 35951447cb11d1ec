#pragma once

#include "sim/mesh/triangle_mesh.h"
#include "sim/tool/profile.h"

namespace reamsim {

/// The outline in (r, z) of everything that a closed mesh sweeps when it turns about z: the union over all angles of
/// its half-plane sections. Sampled on a lattice of `step_mm`; crossings between lattice points are found to below 0.1
/// µm, corners are restored, and points are dropped that lie within step/5 of a straight line. Features thinner than a
/// step may be missed. Closed hollows off the axis are filled, since nothing can reach them.
///
/// `mesh` must be closed and face outwards; mm, frame T. The step grows so that the lattice has at most 4096² points.
/// Throws InputError when the swept body falls into several pieces.
Profile sweep_outline(const TriangleMesh& mesh, double step_mm);

}  // namespace reamsim
