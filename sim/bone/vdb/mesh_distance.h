// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <openvdb/openvdb.h>

#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// The lattice and the band of a sampled distance.
struct DistanceSampling {
  Vec3 first_mm = Vec3::Zero();  ///< sample (0,0,0), in the frame of the mesh
  double spacing_mm = 1;
  double outer_spacings = 3;  ///< half-width of the band outside; the distance is constant beyond it
  double inner_spacings = 3;  ///< likewise inside
  bool exact = false;         ///< without OpenVDB's smoothing of overlapping parts, which also moves edges
};

/// Signed distance of a closed mesh in spacings, negative inside, by sample coordinates. Throws std::bad_alloc or
/// openvdb::Exception.
openvdb::FloatGrid::Ptr mesh_distance(const TriangleMesh& mesh, const DistanceSampling& sampling);

}  // namespace reamsim
