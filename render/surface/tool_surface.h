#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// The tool as triangles for the graphics library.
struct ToolSurface {
  /// Numbers per vertex: position in T (mm), outward normal.
  static constexpr std::array kGroups{3, 3};
  static constexpr std::size_t kStride = 6;

  std::vector<float> vertices;
  std::vector<std::uint32_t> indices;
};

/// Every corner gets the mean normal of the triangles round it that bend away less than a crease does, so that turned
/// faces look round and cutting edges stay sharp.
ToolSurface make_tool_surface(const TriangleMesh& mesh);

}  // namespace reamsim
