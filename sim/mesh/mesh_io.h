// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/mesh/mesh_format.h"
#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// What a mesh file holds.
struct MeshContents {
  TriangleMesh mesh;               ///< in mm; vertices merged, and welded (mesh_repair.h) where the surface has holes
  std::string space;               ///< the frame that the header states: "LPS", "RAS", another; "" without one
  std::vector<std::string> notes;  ///< what was welded
  std::vector<std::string> warnings;  ///< numbers of triangles that the header has wrong, and the like
};

/// Reads an STL, OBJ or PLY file, in a child process, and multiplies by `scale` (file units to mm). What the file is
/// its content says, not its name (mesh_format.h). The coordinates stand as in the file, whatever its frame
/// (sim/bone/mesh_source.h). `key`: that of the scenario, if it names the file. Throws InputError: no such file,
/// another format (with how to convert it), unreadable or truncated, no triangle, NaN or infinite coordinate.
MeshContents read_mesh_contents(const std::string& path, double scale, const std::string& key = "");

/// Its mesh.
TriangleMesh read_mesh(const std::string& path, double scale);

/// Writes a binary STL (mm). Throws RunError when the file cannot be written.
void write_stl(const std::string& path, const TriangleMesh& mesh, const std::string& space = "");

}  // namespace reamsim
