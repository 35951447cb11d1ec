#pragma once

#include <Eigen/Core>
#include <string>
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
  std::vector<float> reamed;             ///< how certain it is that material was removed there, 0…1, per vertex
};

/// Meshes the level set `surface` of the VDB file `path` (mm, negative inside), with the depth of each vertex below
/// `unreamed`. The level is not 0 but the one, some hundredths of a voxel away, at which the mesh encloses the volume
/// that is left, `bone_mm3`: smoothing rounds edges off, and they would be missing. Closed also where the lattice,
/// `grid`, cuts the bone; empty where none is left. Throws InputError when the level set is missing or damaged.
ReamedMesh make_reamed_mesh(const std::string& path, const VoxelGrid& grid, double bone_mm3,
                            const UnreamedSurface& unreamed);

/// Writes a binary glTF 2.0: one mesh with POSITION (B, mm), NORMAL, COLOR_0 (bone, and the depth's colour where it was
/// reamed, `depth_max_mm` at the map's end) and _DEPTH_MM. A node turns B's +z to glTF's +y, which is up. glTF counts
/// in metres by convention; this file counts in mm, like all results, and says so in asset.extras. The exporter of
/// assimp knows no attributes of one's own.
/// Throws RunError when the file cannot be written or exceeds the 4 GiB limit of GLB.
void write_glb(const std::string& path, const ReamedMesh& reamed, double depth_max_mm);

}  // namespace reamsim
