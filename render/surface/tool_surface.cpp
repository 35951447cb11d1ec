// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/surface/tool_surface.h"

#include <cmath>

namespace reamsim {

ToolSurface make_tool_surface(const TriangleMesh& mesh) {
  constexpr double kToolCreaseCosine = 0.80;  // 37°
  const std::size_t count = mesh.triangles.size();
  std::vector<Vec3> areas(count);  // normal times twice the area
  std::vector<std::vector<std::uint32_t>> around(mesh.vertices.size());
  for (std::size_t t = 0; t < count; ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    areas[t] = (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]);
    for (const std::int32_t corner : mesh.triangles[t]) around[corner].push_back(static_cast<std::uint32_t>(t));
  }
  ToolSurface out;
  out.vertices.reserve(count * 3 * ToolSurface::kStride);
  for (std::size_t t = 0; t < count; ++t) {
    const Vec3 own = areas[t].normalized();
    for (const std::int32_t corner : mesh.triangles[t]) {
      Vec3 sum = Vec3::Zero();
      for (const std::uint32_t other : around[corner]) {
        if (areas[other].dot(own) >= kToolCreaseCosine * areas[other].norm()) sum += areas[other];
      }
      const Eigen::Vector3f normal = (sum.norm() > 0 ? sum.normalized() : own).cast<float>();
      const Eigen::Vector3f position = mesh.vertices[corner].cast<float>();
      out.indices.push_back(static_cast<std::uint32_t>(out.vertices.size() / ToolSurface::kStride));
      out.vertices.insert(out.vertices.end(), position.data(), position.data() + 3);
      out.vertices.insert(out.vertices.end(), normal.data(), normal.data() + 3);
    }
  }
  return out;
}

}  // namespace reamsim
