#pragma once

#include <optional>

#include "sim/mesh/triangle_mesh.h"
#include "sim/tool/profile.h"

namespace reamsim {

/// The polygon that a mesh was revolved from, if it was: every triangle spans at most two rings of vertices about z,
/// each ring is fine (facets within 0.02 mm of their circle), and the rings chain into one simple closed polygon, or
/// one that starts and ends on the axis. Vertices are recovered to the precision of the file (about 1 µm for an STL),
/// bores and cups included. Nothing when the mesh is anything else; then sweep_outline() is the way. `mesh` must be
/// closed and face outwards; mm, frame T.
std::optional<Profile> recover_generatrix(const TriangleMesh& mesh);

}  // namespace reamsim
