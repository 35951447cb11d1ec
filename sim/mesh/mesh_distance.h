#pragma once

#include <openvdb/openvdb.h>

#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// Which lattice a mesh's distance is sampled on, and how far from the surface.
struct DistanceSampling {
  Vec3 first_mm = Vec3::Zero();  ///< sample (0,0,0), in the mesh's frame
  double spacing_mm = 1;
  double outer_spacings = 3;  ///< beyond that outside every sample is just that far
  double inner_spacings = 3;
  bool exact = false;  ///< leaves out the smoothing of bumps where parts of the mesh overlap, which moves edges as well
};

/// Signed distance of a closed mesh in spacings, negative inside, by sample indices. Throws std::bad_alloc or
/// openvdb::Exception.
openvdb::FloatGrid::Ptr mesh_distance(const TriangleMesh& mesh, const DistanceSampling& sampling);

}  // namespace reamsim
