// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "sim/verify/closed_forms.h"
#include "sim/verify/reaming.h"

namespace reamsim::verify {

/// The example of docs/physics.md, 6.
inline constexpr SteadyPlunge kExample{29, 15, 1.25, 250, 0.2, 1.8};

/// The example with one factor changed.
template <class Value>
SteadyPlunge example_with(Value SteadyPlunge::*member, std::type_identity_t<Value> value) {
  SteadyPlunge out = kExample;
  out.*member = value;
  return out;
}

/// The profile of the reamer's head.
Profile head_of(const SteadyPlunge& plunge);
/// "R 29, a 15 mm, 250 rpm, 0.2 mm/s".
std::string text_of(const SteadyPlunge& plunge);

/// A steady plunge and its discretization.
struct PlungeRun {
  SteadyPlunge plunge = {};
  double voxel_mm = 0.25;
  int frames = 32;  ///< over one voxel of feed
  int voxels = 1;   ///< of feed, with the face in contact out to its rim
  ErosionMode erosion = ErosionMode::exact;
  double tilt_deg = 0;  ///< of the axis against the lattice
  /// Bone on one side only of a plane through the axis: the side of (cos, sin) of this angle in the tool's x and y.
  /// nullopt: bone under the whole face.
  std::optional<double> half_toward_deg = {};
  std::optional<ComplianceSettings> compliance = {};
};

/// Rows over the voxels of feed with the face in contact out to its rim.
std::vector<FrameResult> steady_rows(const PlungeRun& run, const Setting& setting);

}  // namespace reamsim::verify
