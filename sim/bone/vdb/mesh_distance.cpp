// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/vdb/mesh_distance.h"

#include <openvdb/tools/MeshToVolume.h>

#include <vector>

namespace reamsim {

namespace {

SampledMesh sampled(const TriangleMesh& mesh, const DistanceSampling& sampling) {
  SampledMesh out;
  out.points.reserve(mesh.vertices.size());
  for (const Vec3& vertex : mesh.vertices) {
    const Vec3 index = (vertex - sampling.first_mm) / sampling.spacing_mm;
    out.points.emplace_back(static_cast<float>(index.x()), static_cast<float>(index.y()),
                            static_cast<float>(index.z()));
  }
  out.triangles.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    out.triangles.emplace_back(static_cast<openvdb::Index32>(a), static_cast<openvdb::Index32>(b),
                               static_cast<openvdb::Index32>(c));
  }
  return out;
}

}  // namespace

openvdb::FloatGrid::Ptr mesh_distance(const SampledMesh& mesh, const openvdb::math::Transform& transform,
                                      double outer_spacings, double inner_spacings, bool exact) {
  openvdb::initialize();
  // OpenVDB's library contains the instance for this adapter and interrupter; others take minutes to compile.
  const openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3s, openvdb::Vec3I> adapter(mesh.points, mesh.triangles);
  openvdb::util::NullInterrupter never;
  return openvdb::tools::meshToVolume<openvdb::FloatGrid>(never, adapter, transform, static_cast<float>(outer_spacings),
                                                          static_cast<float>(inner_spacings),
                                                          exact ? openvdb::tools::DISABLE_RENORMALIZATION : 0);
}

openvdb::FloatGrid::Ptr mesh_distance(const TriangleMesh& mesh, const DistanceSampling& sampling) {
  return mesh_distance(sampled(mesh, sampling), *openvdb::math::Transform::createLinearTransform(1.0),
                       sampling.outer_spacings, sampling.inner_spacings, sampling.exact);
}

}  // namespace reamsim
