// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>

#include "sim/mesh/triangle_mesh.h"
#include "sim/tool/profile.h"

namespace reamsim {

/// Step of the lattice that samples the outline of a tool that is no surface of revolution, mm.
inline constexpr double kOutlineStepMm = 0.02;

/// The envelope of revolution about z of a closed mesh that faces outwards (mm, frame T).
struct Envelope {
  Profile profile;
  bool revolved = false;  ///< the mesh is a surface of revolution, and the profile its generating polygon
};

/// recover_generatrix() for a surface of revolution, sweep_outline() for other meshes. Throws InputError when the
/// envelope has no volume.
Envelope envelope_of_revolution(const TriangleMesh& mesh);

/// The generating polygon of a surface of revolution, or nullopt for other meshes: every triangle spans at most two
/// rings of vertices about z, facets lie within 0.02 mm of the circle of their ring, and the rings form one simple
/// closed polygon, or one that begins and ends on the axis. Vertices have the precision of the file (about 1 µm for an
/// STL). Bores and cups are supported. `mesh` must be closed and face outwards; mm, frame T.
std::optional<Profile> recover_generatrix(const TriangleMesh& mesh);

/// The outline in (r, z) of the volume that a closed mesh sweeps when it rotates about z: the union of its half-plane
/// sections. Sampled on a lattice of `step_mm`, which grows to limit the lattice to 4096² points. Crossings between
/// lattice points have an error below 0.1 µm; corners are restored; points within step/5 of a straight line are
/// dropped. Features thinner than a step may be missed. Closed cavities off the axis are filled, since nothing can
/// reach them. `mesh` must be closed and face outwards; mm, frame T. Throws InputError when the swept body has several
/// parts.
Profile sweep_outline(const TriangleMesh& mesh, double step_mm);

}  // namespace reamsim
