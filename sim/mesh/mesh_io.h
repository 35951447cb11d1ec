// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// Reads an STL, OBJ or PLY file with assimp, in a child process, multiplies by `scale` (file units to mm) and merges
/// vertices at equal positions, as the triangles of an STL need. Throws InputError: no such file, a VTK file (with how
/// to convert it), unreadable or truncated, no triangle, NaN or infinite coordinate.
TriangleMesh read_mesh(const std::string& path, double scale);

/// Writes a binary STL (mm). Throws RunError when the file cannot be written.
void write_stl(const std::string& path, const TriangleMesh& mesh, const std::string& space = "");

// A binary STL.
inline constexpr std::size_t kStlHeaderBytes = 84;
inline constexpr std::size_t kStlTriangleBytes = 50;

/// A mesh file before it is read.
struct MeshFile {
  std::string extension;  ///< "stl", "obj" or "ply"
  std::uintmax_t bytes = 0;
};

/// Throws InputError at a key of the scenario unless the name of the file ends as that of a mesh.
void require_mesh_name(const std::string& path, const std::string& key);

/// Checks the name, size and header of a mesh file, whose counts the library that reads it trusts. Throws InputError.
MeshFile check_mesh_file(const std::string& path);

}  // namespace reamsim
