// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "render/surface/solid_field.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// The bone after reaming as one closed surface, for slicing, printing and viewers.
struct ReamedMesh {
  TriangleMesh mesh;                     ///< B, mm, counter-clockwise seen from outside
  std::vector<Eigen::Vector3f> normals;  ///< outward, unit length, per vertex
  std::vector<float> depth_mm;           ///< below the unreamed surface, per vertex; 0 where nothing was reamed
  std::vector<float> reamed;             ///< certainty that material was removed there, 0…1, per vertex
};

/// Meshes the level set `surface` of the VDB file `path` (mm, negative inside), with the depth of each vertex below
/// `unreamed`. The level is chosen, within some hundredths of a voxel of 0, so that the mesh encloses the remaining
/// volume `bone_mm3`, which smoothing of edges would reduce. The mesh is closed where the lattice `grid` cuts the bone,
/// and empty where no bone remains. Throws InputError when the level set is missing or damaged.
ReamedMesh make_reamed_mesh(const std::string& path, const VoxelGrid& grid, double bone_mm3,
                            const UnreamedSurface& unreamed);

/// Writes a binary glTF 2.0: one mesh with POSITION (B, mm), NORMAL, COLOR_0 (bone, or the depth colour where it was
/// reamed, `depth_max_mm` at the end of the map) and _DEPTH_MM. A node rotates +z of B to +y of glTF, which is up. The
/// unit is mm, not glTF's metre; asset.extras states it. Not assimp, whose exporter supports no custom attributes.
/// Throws RunError when the file cannot be written or exceeds the 4 GiB limit of GLB.
void write_glb(const std::string& path, const ReamedMesh& reamed, double depth_max_mm);

}  // namespace reamsim
