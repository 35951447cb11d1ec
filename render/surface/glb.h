#pragma once

#include <string>

#include "render/surface/reamed_mesh.h"

namespace reamsim {

/// Writes a binary glTF 2.0: one mesh with POSITION (B, mm), NORMAL, COLOR_0 (bone, and the depth's colour where it was
/// reamed, `depth_max_mm` at the map's end) and _DEPTH_MM. A node turns B's +z to glTF's +y, which is up. glTF counts
/// in metres by convention; this file counts in mm, like all results, and says so in asset.extras. The exporter of
/// assimp knows no attributes of one's own.
/// Throws RunError when the file cannot be written or would pass the format's 4 GiB.
void write_glb(const std::string& path, const ReamedMesh& reamed, double depth_max_mm);

}  // namespace reamsim
