#include "sim/mesh/triangle_mesh.h"

#include <limits>

namespace reamsim {

Aabb TriangleMesh::bounds() const {
  constexpr double kHuge = std::numeric_limits<double>::infinity();
  Aabb box{Vec3::Constant(kHuge), Vec3::Constant(-kHuge)};
  for (const Vec3& vertex : vertices) {
    box.min = box.min.cwiseMin(vertex);
    box.max = box.max.cwiseMax(vertex);
  }
  return box;
}

double TriangleMesh::volume_mm3() const {
  if (vertices.empty()) return 0;
  const Vec3 pivot = bounds().center();  // near the mesh, so that far-off meshes lose no digits
  double six_volumes = 0;
  for (const auto& [a, b, c] : triangles) {
    const Vec3 pa = vertices[static_cast<std::size_t>(a)] - pivot;
    const Vec3 pb = vertices[static_cast<std::size_t>(b)] - pivot;
    const Vec3 pc = vertices[static_cast<std::size_t>(c)] - pivot;
    six_volumes += pa.dot(pb.cross(pc));
  }
  return six_volumes / 6;
}

}  // namespace reamsim
