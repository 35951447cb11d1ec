// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <optional>
#include <vector>

#include "sim/bone/voxmap/voxmap.h"
#include "sim/engine/common/substep.h"
#include "sim/tool/tool.h"

namespace reamsim::bench {

/// Edge of the cube of bone, mm; the same at every resolution. Frame B of the glenoid phantom: +x lateral out of the
/// face, +z superior, origin at the face's centre.
inline constexpr double kBoxMm = 40;
/// Radius of the hemispherical reamer, mm.
inline constexpr double kReamerMm = 14;

/// The glenoid phantom with `side`³ voxels in the same cube. It is sampled once, at 256³; finer voxmaps interpolate and
/// coarser ones average, as the paper resizes its CT.
class BoneSeries {
 public:
  /// `sampled`: voxels along an edge of the sampled phantom; a power of two.
  explicit BoneSeries(int sampled = 256);

  /// `side`: a power of two. Takes a few seconds at 1024.
  [[nodiscard]] FilledVoxmap at(int side) const;
  /// The box of the bone in B, mm, for the broad phase at this resolution.
  [[nodiscard]] Aabb box(int side) const;

 private:
  FilledVoxmap sampled_;
  Aabb box_mm_;
};

/// The hemispherical cap of the reamer without its lid, sampled in a `resolution`³ grid that spans the whole scanned
/// reamer. The cap spans kCapFraction of its edge, which gives the paper's number of points at every resolution.
inline constexpr double kCapFraction = 0.6945;
Tool cap_tool(int resolution);

/// A tool from its profile, with a shell of at most 1024³ cells. Without a spacing it gets a minimal shell, because
/// exact erosion does not use one.
Tool make_tool(const Profile& profile, std::optional<double> shell_spacing_mm = {});

/// Box of the shell points, T, mm: half a cell beyond the surface.
inline Aabb shell_box(const Tool& tool) {
  return tool.bounds.expanded(0.5 * tool.shell.cell_mm);
}

/// The program's default cutting settings with whole voxels removed.
inline CuttingSettings bench_cutting() {
  return {.erosion = ErosionMode::remove};
}

/// The paper's cases of contact: in `severe` 103,000 points touch with voxmap and shell at 1024³, in `light` 1 % of the
/// points; in `none` the boxes overlap and no point touches.
enum class Contact { severe, light, none };
inline constexpr std::array<Contact, 3> kContacts{Contact::severe, Contact::light, Contact::none};
const char* name_of(Contact contact);

/// A straight path of the reamer into the glenoid face. Lengths in mm, frame B; depth is along −z of T, 0 with the
/// lowest point of the reamer on the face.
struct Approach {
  double posterior_mm, superior_mm;        ///< position on the face
  double tilt_posterior_deg, tilt_up_deg;  ///< of the spin axis against the face's normal
  std::array<double, 3> depth_mm;          ///< by Contact, found at 1024³ × 1024³ (tests/bench/scene_test.cpp)
};

/// Different positions and tilts; the same at every resolution.
extern const std::array<Approach, 4> kApproaches;

/// The tool at a depth of an approach.
ToolPose pose_at(const Approach& approach, double depth_mm);
/// A substep of one millisecond that ends at `pose`, with a feed of 1 mm/s along the axis and 250 rpm.
Substep substep_at(const ToolPose& pose);
/// The approaches' substeps of a case.
std::vector<Substep> substeps_of(Contact contact);

/// Arguments of a substep whose VOI is the whole shell.
SubstepArgs args_without_voi(const Substep& substep, const Tool& tool, const VoxelGrid& grid);

/// Number of shell points in bone, in the arithmetic of the deterministic engines. Uses every core.
std::int64_t count_touching(const Voxmap& voxmap, const Tool& tool, const Substep& substep);

/// Touching points of a case with a shell of `points`.
double wanted_points(Contact contact, double points);

// The plunged sphere: a cap that a spherical tool cuts along z into the flat face of a block. Frame B: face at z = 0,
// +z out of the bone.
inline constexpr double kSphereRadiusMm = 29;
inline constexpr double kSphereDepthMm = 4;  ///< of the whole plunge
inline constexpr double kSphereFeedMmS = 0.2;
inline constexpr double kSphereFrameS = 1e-3;

/// A block of uniform bone under the sphere, offset from the tool's axis by fractions of a voxel so that nothing is
/// regular.
FilledVoxmap sphere_block(double voxel_mm);

/// The tool: a cap of the sphere with a cylinder above it, and the shell that `reamsim run` chooses, of at most 1024³
/// cells.
Tool sphere_cap(double voxel_mm);

/// The substep of a frame that ends at `depth_mm`, at the plunge's feed rate and 250 rpm. `number`: of the frame.
Substep sphere_frame(double depth_mm, std::int64_t number);

}  // namespace reamsim::bench
