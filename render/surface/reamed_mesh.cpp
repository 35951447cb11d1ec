#include "render/surface/reamed_mesh.h"

#include <algorithm>
#include <cmath>

#include "render/surface/scalar_grid.h"
#include "render/surface/surface_smoothing.h"
#include "sim/base/parallel.h"
#include "sim/bone/vdb/vdb_archive.h"

namespace reamsim {
namespace {

constexpr std::size_t kMeshGrain = 2048;
constexpr int kMeshDepthRounds = 5;  // smooths the voxels' steps in what is found at the vertices
constexpr int kCorrections = 2;      // of the level; the second is for thin bone, whose area changes with the first
constexpr double kMostShift_voxels = 0.5;

TriangleMesh mesh_at(const openvdb::FloatGrid& surface, double level_mm) {
  const IsoSurface iso = extract_surface(surface, level_mm);
  TriangleMesh mesh;
  mesh.vertices.reserve(iso.points.size());
  for (const Eigen::Vector3f& p : iso.points) mesh.vertices.emplace_back(p.cast<double>());
  mesh.triangles.reserve(iso.indices.size() / 3);
  // OpenVDB turns the triangles of a level set inwards.
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

/// The mesh at the level where it encloses `volume_mm3`, found by Newton's method: a volume grows with the level as
/// fast as the surface has area.
TriangleMesh mesh_of_volume(const openvdb::FloatGrid& surface, double volume_mm3, double voxel_mm) {
  double level_mm = 0;
  TriangleMesh mesh = mesh_at(surface, level_mm);
  for (int i = 0; i < kCorrections && !mesh.triangles.empty(); ++i) {
    const double most_mm = kMostShift_voxels * voxel_mm;
    level_mm = std::clamp(level_mm + (volume_mm3 - mesh.volume_mm3()) / area_mm2(mesh), -most_mm, most_mm);
    mesh = mesh_at(surface, level_mm);
  }
  return mesh;
}

std::vector<std::uint32_t> corner_indices(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> out;
  out.reserve(3 * mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    for (const std::int32_t corner : triangle) out.push_back(static_cast<std::uint32_t>(corner));
  }
  return out;
}

/// Means over the triangles round each vertex, weighted by their area.
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

void find_depths(ReamedMesh& out, const VoxelGrid& grid, const UnreamedSurface& unreamed) {
  const std::size_t count = out.mesh.vertices.size();
  out.depth_mm.assign(count, 0);
  out.reamed.assign(count, 0);
  parallel_ranges(count, kMeshGrain, [&](std::size_t begin, std::size_t end) {
    const ReamingSampler sampler(unreamed);
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 at = (out.mesh.vertices[i] - grid.origin_mm) / grid.voxel_mm - Vec3::Constant(0.5);
      const openvdb::Vec3d index(at.x(), at.y(), at.z());
      out.reamed[i] = sampler.fraction(index);
      if (out.reamed[i] > 0) out.depth_mm[i] = sampler.depth_mm(index * grid.voxel_mm);
    }
  });
  const Neighbours neighbours(count, corner_indices(out.mesh));
  std::vector<Eigen::Vector3f> points;
  for (const Vec3& p : out.mesh.vertices) points.emplace_back(((p - grid.origin_mm) / grid.voxel_mm).cast<float>());
  const std::vector<float> even = mean_value_weights(neighbours, points);
  smooth_values(neighbours, even, out.reamed, out.depth_mm, kMeshDepthRounds);
  smooth_values(neighbours, even, std::vector<float>(count, 1), out.reamed, kMeshDepthRounds);
}

}  // namespace

ReamedMesh make_reamed_mesh(const std::string& path, const VoxelGrid& grid, double bone_mm3,
                            const UnreamedSurface& unreamed) {
  ReamedMesh out;
  out.mesh = mesh_of_volume(*VdbFile(path).read("surface"), bone_mm3, grid.voxel_mm);
  out.normals = vertex_normals(out.mesh);
  find_depths(out, grid, unreamed);
  return out;
}

}  // namespace reamsim
