// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// Reads an STL, OBJ or PLY file with assimp, in a child process, multiplies by `scale` (file units to mm) and merges
/// vertices at equal positions, as the triangles of an STL need. Throws InputError: no such file, a VTK file (with how
/// to convert it), unreadable or truncated, no triangle, NaN or infinite coordinate.
TriangleMesh read_mesh(const std::string& path, double scale);

/// Writes a binary STL (mm). Throws RunError when the file cannot be written.
void write_stl(const std::string& path, const TriangleMesh& mesh);

}  // namespace reamsim
