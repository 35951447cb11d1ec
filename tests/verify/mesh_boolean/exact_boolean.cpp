// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The only file that includes CGAL, whose headers take long to compile.
#include "tests/verify/mesh_boolean/exact_boolean.h"

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Surface_mesh.h>

#include <cmath>
#include <stdexcept>

namespace reamsim::test {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Surface = CGAL::Surface_mesh<Point>;

Point point(const Vec3& p) {
  return {p.x(), p.y(), p.z()};
}

Surface surface_of(const TriangleMesh& mesh) {
  Surface out;
  std::vector<Surface::Vertex_index> vertices;
  for (const Vec3& vertex : mesh.vertices) vertices.push_back(out.add_vertex(point(vertex)));
  const auto at = [&](std::int32_t i) { return vertices[static_cast<std::size_t>(i)]; };
  for (const auto& [a, b, c] : mesh.triangles) out.add_face(at(a), at(b), at(c));
  if (out.number_of_faces() != mesh.triangles.size() || !CGAL::is_closed(out)) {
    throw std::runtime_error("mesh_difference: not a closed two-manifold surface");
  }
  return out;
}

TriangleMesh mesh_of(const Surface& surface) {
  TriangleMesh out;
  std::vector<std::int32_t> index(surface.number_of_vertices() + surface.number_of_removed_vertices());
  for (const auto vertex : surface.vertices()) {
    const Point& p = surface.point(vertex);
    index[vertex] = static_cast<std::int32_t>(out.vertices.size());
    out.vertices.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto face : surface.faces()) {
    MeshTriangle triangle;
    std::size_t corner = 0;
    for (const auto vertex : surface.vertices_around_face(surface.halfedge(face))) triangle[corner++] = index[vertex];
    out.triangles.push_back(triangle);
  }
  return out;
}

}  // namespace

TriangleMesh mesh_difference(const TriangleMesh& a, const TriangleMesh& b) {
  namespace parameters = CGAL::parameters;
  Surface minuend = surface_of(a), subtrahend = surface_of(b), out;
  const auto checked = parameters::throw_on_self_intersection(true);
  if (!CGAL::Polygon_mesh_processing::corefine_and_compute_difference(minuend, subtrahend, out, checked)) {
    throw std::runtime_error("mesh_difference: the result is not a two-manifold surface");
  }
  return mesh_of(out);
}

std::vector<double> distances_mm(const std::vector<Vec3>& points, const TriangleMesh& mesh) {
  using Primitive = CGAL::AABB_face_graph_triangle_primitive<Surface>;
  const Surface surface = surface_of(mesh);
  CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>> tree(faces(surface).first, faces(surface).second, surface);
  tree.accelerate_distance_queries();
  std::vector<double> out;
  for (const Vec3& p : points) out.push_back(std::sqrt(tree.squared_distance(point(p))));
  return out;
}

}  // namespace reamsim::test
