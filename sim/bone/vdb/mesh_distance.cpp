// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/vdb/mesh_distance.h"

#include <openvdb/tools/MeshToVolume.h>

#include <vector>

namespace reamsim {

namespace {

/// A mesh in the index space of the lattice.
struct IndexSpaceMesh {
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;

  IndexSpaceMesh(const TriangleMesh& mesh, const DistanceSampling& sampling) {
    points.reserve(mesh.vertices.size());
    for (const Vec3& vertex : mesh.vertices) {
      const Vec3 index = (vertex - sampling.first_mm) / sampling.spacing_mm;
      points.emplace_back(static_cast<float>(index.x()), static_cast<float>(index.y()), static_cast<float>(index.z()));
    }
    triangles.reserve(mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles) {
      triangles.emplace_back(static_cast<openvdb::Index32>(a), static_cast<openvdb::Index32>(b),
                             static_cast<openvdb::Index32>(c));
    }
  }
};

}  // namespace

openvdb::FloatGrid::Ptr mesh_distance(const TriangleMesh& mesh, const DistanceSampling& sampling) {
  openvdb::initialize();
  const IndexSpaceMesh indexed(mesh, sampling);
  const auto transform = openvdb::math::Transform::createLinearTransform(1.0);
  // OpenVDB's library contains the instance for this adapter and interrupter; others take minutes to compile.
  const openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3s, openvdb::Vec3I> adapter(indexed.points,
                                                                                           indexed.triangles);
  openvdb::util::NullInterrupter never;
  return openvdb::tools::meshToVolume<openvdb::FloatGrid>(
      never, adapter, *transform, static_cast<float>(sampling.outer_spacings),
      static_cast<float>(sampling.inner_spacings), sampling.exact ? openvdb::tools::DISABLE_RENORMALIZATION : 0);
}

}  // namespace reamsim
