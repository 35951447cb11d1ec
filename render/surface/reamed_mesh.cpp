// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/surface/reamed_mesh.h"

#include <algorithm>
#include <utility>

#include "render/surface/scalar_grid.h"
#include "sim/bone/vdb/vdb_archive.h"

namespace reamsim {
namespace {

constexpr int kMeshSmoothingRounds = 5;
constexpr int kNewtonSteps = 2;  // of the level; the second matters for thin bone, whose area changes with the level
constexpr double kMaxShift_voxels = 0.5;

TriangleMesh mesh_at(const openvdb::FloatGrid& surface, double level_mm) {
  const IsoSurface iso = extract_surface(surface, level_mm);
  TriangleMesh mesh;
  mesh.vertices.reserve(iso.points.size());
  for (const Eigen::Vector3f& p : iso.points) mesh.vertices.emplace_back(p.cast<double>());
  mesh.triangles.reserve(iso.indices.size() / 3);
  // OpenVDB orients the triangles of a level set inwards.
  const auto corner = [&](std::size_t i) { return static_cast<std::int32_t>(iso.indices[i]); };
  for (std::size_t i = 0; i < iso.indices.size(); i += 3) {
    mesh.triangles.push_back({corner(i), corner(i + 2), corner(i + 1)});
  }
  return mesh;
}

Vec3 doubled_area(const TriangleMesh& mesh, const std::array<std::int32_t, 3>& t) {
  const Vec3& a = mesh.vertices[static_cast<std::size_t>(t[0])];
  return (mesh.vertices[static_cast<std::size_t>(t[1])] - a).cross(mesh.vertices[static_cast<std::size_t>(t[2])] - a);
}

double area_mm2(const TriangleMesh& mesh) {
  double doubled = 0;
  for (const auto& triangle : mesh.triangles) doubled += doubled_area(mesh, triangle).norm();
  return doubled / 2;
}

/// The mesh at the level where it encloses `volume_mm3`, by Newton's method: the derivative of the volume with respect
/// to the level is the surface area.
TriangleMesh mesh_of_volume(const openvdb::FloatGrid& surface, double volume_mm3, double voxel_mm) {
  double level_mm = 0;
  TriangleMesh mesh = mesh_at(surface, level_mm);
  for (int i = 0; i < kNewtonSteps && !mesh.triangles.empty(); ++i) {
    const double max_mm = kMaxShift_voxels * voxel_mm;
    level_mm = std::clamp(level_mm + (volume_mm3 - mesh.volume_mm3()) / area_mm2(mesh), -max_mm, max_mm);
    mesh = mesh_at(surface, level_mm);
  }
  return mesh;
}

/// Area-weighted means of the triangle normals at each vertex.
std::vector<Eigen::Vector3f> vertex_normals(const TriangleMesh& mesh) {
  std::vector<Vec3> sums(mesh.vertices.size(), Vec3::Zero());
  for (const auto& triangle : mesh.triangles) {
    const Vec3 normal = doubled_area(mesh, triangle);
    for (const std::int32_t corner : triangle) sums[static_cast<std::size_t>(corner)] += normal;
  }
  std::vector<Eigen::Vector3f> out(sums.size());
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const double length = sums[i].norm();
    out[i] = length > 0 ? Eigen::Vector3f((sums[i] / length).cast<float>()) : Eigen::Vector3f::UnitZ();
  }
  return out;
}

void add_reaming(ReamedMesh& out, const VoxelGrid& grid, const UnreamedSurface& unreamed) {
  const auto voxel = [&](std::size_t i) {
    const Vec3 at = (out.mesh.vertices[i] - grid.origin_mm) / grid.voxel_mm - Vec3::Constant(0.5);
    return openvdb::Vec3d(at.x(), at.y(), at.z());
  };
  // Without the field of the current bone the certainty stands for the edge as well.
  std::vector<Removal> removal(out.mesh.vertices.size());
  const ReamingSampler sampler(unreamed);
  for (std::size_t i = 0; i < removal.size(); ++i) {
    const float certainty = sampler.fraction(voxel(i));
    removal[i] = {certainty, certainty};
  }
  Reaming reaming = reaming_at(removal, unreamed, [&](std::size_t i) { return voxel(i) * grid.voxel_mm; });
  std::vector<Eigen::Vector3f> points;
  for (const Vec3& p : out.mesh.vertices) points.emplace_back(((p - grid.origin_mm) / grid.voxel_mm).cast<float>());
  std::vector<std::uint32_t> corners;
  for (const auto& triangle : out.mesh.triangles) corners.insert(corners.end(), triangle.begin(), triangle.end());
  reaming.smooth({points.size(), corners}, points, kMeshSmoothingRounds, kMeshSmoothingRounds);
  out.depth_mm = std::move(reaming.depth_mm);
  out.reamed = std::move(reaming.reamed);
}

}  // namespace

ReamedMesh make_reamed_mesh(const std::string& path, const VoxelGrid& grid, double bone_mm3,
                            const UnreamedSurface& unreamed) {
  ReamedMesh out;
  out.mesh = mesh_of_volume(*VdbFile(path).read("surface"), bone_mm3, grid.voxel_mm);
  out.normals = vertex_normals(out.mesh);
  add_reaming(out, grid, unreamed);
  return out;
}

}  // namespace reamsim
