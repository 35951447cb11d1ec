// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "sim/bench/scene.h"
#include "sim/bone/phantom.h"
#include "sim/engine/common/engine.h"
#include "sim/run/balance.h"
#include "sim/run/simulation.h"
#include "sim/verify/closed_forms.h"

namespace reamsim::verify {

// ---- tools ------------------------------------------------------------------------------------------------------

// Curves are points at a spacing of `edge_mm`; exact erosion fits arcs to them (sim/tool/profile.h).

/// A ball that touches z = 0 from above.
Profile ball_profile(double radius_mm, double edge_mm);
/// The head of a convex reamer: a spherical face of `radius_mm` out to `outer_mm`, bored to `bore_mm` (0: not bored),
/// `height_mm` tall.
Profile convex_profile(double radius_mm, double outer_mm, double bore_mm, double height_mm, double edge_mm);
/// The same with a flat face.
Profile flat_profile(double outer_mm, double bore_mm, double height_mm);

using bench::make_tool;

// ---- bones -----------------------------------------------------------------------------------------------------

/// The lattice of a block with its top face at z = 0 and its middle at x = y = 0. Extents are rounded up to even
/// numbers of voxels.
VoxelGrid block_grid(const Vec3& size_mm, double voxel_mm);
/// A block on this lattice with the density `field` (g/cm³) at the centres of the voxels.
FilledVoxmap block(const Vec3& size_mm, double voxel_mm, const DensityField& field);
/// The part of the block in front of the plane through `point_mm` with the normal `inward`.
FilledVoxmap half_block(const Vec3& size_mm, double voxel_mm, const DensityField& field, const Vec3& point_mm,
                        const Vec3& inward);
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

// ---- reaming ---------------------------------------------------------------------------------------------------

/// Makes the engine of a scene, as make_engine() does.
using EngineMaker = std::function<std::unique_ptr<Engine>(const Scenario&, const BoneView&, const Tool&)>;

struct Setting {
  bool quick = true;
  std::string device = "auto";
  /// Tests of the suite put an engine with a wrong constant here.
  EngineMaker engine = make_engine;
  /// Called before each case of the suite, with the fraction of the expected time that lies behind, and at the end.
  std::function<void(double, const std::string&)> part = [](double, const std::string&) {};
  std::function<bool()> stop = [] { return false; };
};

/// The result of reaming a scene.
struct Reamed {
  std::vector<FrameResult> rows;  ///< rows[k] is frame k
  Bone bone;                      ///< after reaming
  FeedState feed = {};            ///< under thrust
  SpringState springs = {};       ///< after a run of a tool on springs

  /// Sum over the rows.
  [[nodiscard]] double sum(double FrameResult::*member) const {
    double out = 0;
    for (const FrameResult& row : rows) out += row.*member;
    return out;
  }
  [[nodiscard]] double removed_mm3() const { return sum(&FrameResult::removed_mm3); }
  /// Rows of the frames after `frame`.
  [[nodiscard]] std::span<const FrameResult> after(std::size_t frame) const {
    return std::span(rows).subspan(frame + 1);
  }
};

/// Reams the scene with the program's main loop. Throws InputError (no such device), RunError, Interrupted.
Reamed ream(SimulationInput scene, const Setting& setting);

struct MeanLoads {
  Vec3 force_n = Vec3::Zero();
  Vec3 torque_nmm = Vec3::Zero();
  double axial_force_n = 0;
  double spin_torque_nmm = 0;
  double removed_mm3 = 0;  ///< sum, not mean
};
/// Means over rows.
MeanLoads mean_loads(std::span<const FrameResult> rows);
/// Standard deviation of the rows' spin torque over its mean.
double torque_ripple(std::span<const FrameResult> rows);
/// The time constant of what decays exponentially, from its values missing(row) at two frames.
double time_constant_s(const Reamed& reamed, std::size_t a, std::size_t b,
                       const std::function<double(const FrameResult&)>& missing);
/// A place in the face of a block, off the lattice by fractions of a voxel, so that nothing is regular.
Vec3 entry_mm(double voxel_mm);
/// A direction in the plane z = 0, from +x towards +y.
Vec3 toward(double degrees);

/// The example of docs/physics.md, 6.
inline constexpr SteadyPlunge kExample{29, 15, 1.25, 250, 0.2, 1.8};

/// The example with a flat face.
inline constexpr SteadyPlunge kFlatExample{std::nullopt, 15, 1.25, 250, 0.2, 1.8};

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
