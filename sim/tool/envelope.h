#pragma once

#include "sim/mesh/triangle_mesh.h"
#include "sim/tool/profile.h"

namespace reamsim {

/// Lattice step of the outline of a tool that is no surface of revolution, mm.
inline constexpr double kOutlineStepMm = 0.02;

/// The envelope of revolution about z of a closed mesh that faces outwards (mm, frame T), and how it was found.
struct Envelope {
  Profile profile;
  bool revolved = false;  ///< the mesh is a surface of revolution, and the profile is the polygon it was made from
};

/// Recovers the generating polygon of a surface of revolution (recover_generatrix), or traces the outline that any
/// other mesh sweeps (sweep_outline). Throws InputError when there is no such outline.
Envelope envelope_of_revolution(const TriangleMesh& mesh);

}  // namespace reamsim
