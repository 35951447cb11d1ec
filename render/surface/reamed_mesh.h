#pragma once

#include <openvdb/openvdb.h>

#include <Eigen/Core>
#include <vector>

#include "render/surface/unreamed_surface.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// The bone after reaming as one closed surface, for slicing, printing and viewers.
struct ReamedMesh {
  TriangleMesh mesh;                     ///< B, mm, counter-clockwise seen from outside
  std::vector<Eigen::Vector3f> normals;  ///< outward, of length 1, per vertex
  std::vector<float> depth_mm;           ///< below the unreamed surface, per vertex; 0 where nothing was reamed
  std::vector<float> reamed;             ///< how surely material is gone there, 0…1, per vertex
};

/// Meshes `surface`, the level set of reamed.vdb (mm, negative inside), and asks `unreamed` for the depth of each
/// vertex. The level is not 0 but the one, some hundredths of a voxel away, at which the mesh encloses the volume that
/// is left, `bone_mm3`: smoothing rounds edges off, and they would be missing. Closed also where the lattice, `grid`,
/// cuts the bone; empty where none is left.
ReamedMesh make_reamed_mesh(const openvdb::FloatGrid& surface, const VoxelGrid& grid, double bone_mm3,
                            const UnreamedSurface& unreamed);

}  // namespace reamsim
