// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "sim/base/geometry.h"
#include "sim/scenario/choices.h"

namespace reamsim {

/// A small run as `reamsim run` would leave it, made from formulas: a glenoid-like bone (an ellipsoid with a concave
/// face, dense outside and light inside) with a bump on its superior rim, reamed by a convex tool of radius 29 mm.
struct FixtureOptions {
  double voxel_mm = 0.5;
  int frames = 60;
  int every = 20;             ///< a snapshot every so many frames
  double depth_mm = 3.0;      ///< of the tool's lowest point below the face
  bool whole_voxels = false;  ///< erosion by whole voxels instead of fractions
  bool glenoid = true;        ///< with the frame G in the metadata
  BodySide side = BodySide::left;
};

/// The fixture's truth.
struct FixtureTruth {
  Rigid bone_from_glenoid;
  double tool_radius_mm = 29;
  double head_radius_mm = 13;
  double bump_mm = 15;  ///< distance of the bump from the glenoid's centre, superior
  double deepest_mm = 0;
};

/// Writes reamed.vdb, snapshots/, snapshots/tool.stl and forces.csv into `dir`, which exists.
FixtureTruth write_results(const std::string& dir, const FixtureOptions& options);

}  // namespace reamsim
