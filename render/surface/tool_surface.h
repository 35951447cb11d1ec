// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// The tool as a triangle mesh for OpenGL.
struct ToolSurface {
  /// Floats per vertex: position in T (mm), outward normal.
  static constexpr std::array kAttributeSizes{3, 3};
  static constexpr std::size_t kStride = 6;

  std::vector<float> vertices;
  std::vector<std::uint32_t> indices;
};

/// Each corner gets the mean normal of the adjacent triangles within the crease angle: turned faces are shaded
/// smoothly, and cutting edges stay sharp.
ToolSurface make_tool_surface(const TriangleMesh& mesh);

}  // namespace reamsim
