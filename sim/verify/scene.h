#pragma once

#include "sim/bone/sample_phantom.h"
#include "sim/run/simulation.h"

namespace reamsim::verify {

// ---- tools ------------------------------------------------------------------------------------------------------

// A curve is given by points on it, `edge_mm` apart: exact erosion takes the arc through them (sim/tool/outline.h).

/// A ball that touches z = 0 from above.
Profile ball_profile(double radius_mm, double edge_mm);
/// The head of a convex reamer: a spherical face of `radius_mm` out to `outer_mm`, bored to `bore_mm` (0: not bored),
/// `height_mm` tall.
Profile convex_profile(double radius_mm, double outer_mm, double bore_mm, double height_mm, double edge_mm);
/// The same with a flat face.
Profile flat_profile(double outer_mm, double bore_mm, double height_mm);

/// A tool made from its profile. Exact erosion has no shell: without a spacing the tool gets one of a few points.
Tool make_tool(const Profile& profile, std::optional<double> shell_spacing_mm = {});

// ---- bones -----------------------------------------------------------------------------------------------------

/// The lattice of a block whose top face is z = 0, its middle at x = y = 0.
VoxelGrid block_grid(const Vec3& size_mm, double voxel_mm);
/// A block whose top face is z = 0, its middle at x = y = 0, of the density that `field` (g/cm³) has at the voxels'
/// centres. Extents are rounded up to whole voxels, an even number of them in x and y.
FilledVoxmap block(const Vec3& size_mm, double voxel_mm, const DensityField& field);
/// Of one density.
FilledVoxmap block(const Vec3& size_mm, double voxel_mm, double density_g_cm3);

// ---- paths -----------------------------------------------------------------------------------------------------

/// A straight part of a path: where it ends, in how many frames, and at which spin.
struct Leg {
  Vec3 to_mm = Vec3::Zero();
  int frames = 1;
  double rpm = 250;
  Quat turned = Quat::Identity();  ///< orientation at its end
};

/// The rotation about an axis of any length.
Quat rotation(const Vec3& axis, double degrees);

/// A path of legs; the tool stands at `from_mm` first, turned as at the end of the first leg.
Motion path(double rate_hz, const Vec3& from_mm, const std::vector<Leg>& legs);

/// The tool's origin when a ball of `radius_mm`, its axis turned, has its centre at `center_mm`.
Vec3 ball_origin(const Vec3& center_mm, double radius_mm, const Quat& turned);

/// The scene with the suite's cutting law.
ReamingScene scene_of(FilledVoxmap bone, Tool tool, Motion motion, ErosionMode erosion = ErosionMode::exact);

}  // namespace reamsim::verify
