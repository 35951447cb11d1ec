// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/bone/phantom.h"
#include "sim/run/simulation.h"

namespace reamsim::verify {

// ---- tools ------------------------------------------------------------------------------------------------------

// Curves are points at a spacing of `edge_mm`; exact erosion fits arcs to them (sim/tool/outline.h).

/// A ball that touches z = 0 from above.
Profile ball_profile(double radius_mm, double edge_mm);
/// The head of a convex reamer: a spherical face of `radius_mm` out to `outer_mm`, bored to `bore_mm` (0: not bored),
/// `height_mm` tall.
Profile convex_profile(double radius_mm, double outer_mm, double bore_mm, double height_mm, double edge_mm);
/// The same with a flat face.
Profile flat_profile(double outer_mm, double bore_mm, double height_mm);

/// A tool from its profile. Without a shell spacing it gets a minimal shell, because exact erosion does not use one.
Tool make_tool(const Profile& profile, std::optional<double> shell_spacing_mm = {});

// ---- bones -----------------------------------------------------------------------------------------------------

/// The lattice of a block with its top face at z = 0 and its middle at x = y = 0. Extents are rounded up to even
/// numbers of voxels.
VoxelGrid block_grid(const Vec3& size_mm, double voxel_mm);
/// A block on this lattice with the density `field` (g/cm³) at the centres of the voxels.
FilledVoxmap block(const Vec3& size_mm, double voxel_mm, const DensityField& field);
/// A block of uniform density.
FilledVoxmap block(const Vec3& size_mm, double voxel_mm, double density_g_cm3);

// ---- paths -----------------------------------------------------------------------------------------------------

/// A straight part of a path.
struct Leg {
  Vec3 to_mm = Vec3::Zero();
  int frames = 1;
  double rpm = 250;
  Quat turned = Quat::Identity();  ///< orientation at the end
};

/// The rotation about an axis of any length.
Quat rotation(const Vec3& axis, double degrees);

/// A path of legs from `from_mm`. Its first orientation is that at the end of the first leg.
Motion path(double rate_hz, const Vec3& from_mm, const std::vector<Leg>& legs);

/// The origin of a ball tool with its centre at `center_mm` and its axis rotated by `turned`.
Vec3 ball_origin(const Vec3& center_mm, double radius_mm, const Quat& turned);

/// The scene with the suite's cutting law.
SimulationInput scene_of(FilledVoxmap bone, Tool tool, Motion motion, ErosionMode erosion = ErosionMode::exact);

}  // namespace reamsim::verify
