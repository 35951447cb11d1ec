// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <string>
#include <vector>

#include "sim/bench/scene.h"

namespace reamsim::bench {

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
  std::array<double, 3> depth_mm;          ///< by Contact, found by find_depth() at 1024³ × 1024³
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

/// Depth at which `wanted` points touch, within 0.2 %, by bisection; for wanted = 0 kClearance_mm above the first
/// contact.
double find_depth(const Voxmap& voxmap, const Tool& tool, const Approach& approach, double wanted);
inline constexpr double kClearance_mm = 0.3;
/// Touching points of a case with a shell of `points`.
double wanted_points(Contact contact, double points);

}  // namespace reamsim::bench
