// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sim/bone/vdb/bone_vdb.h"
#include "sim/bone/voxmap/sparse_bricks.h"
#include "sim/tool/motion.h"

namespace reamsim {

/// The hand in a frame of a push.
struct PushResult {
  double feed_mm_s = 0;      ///< mean over the frame
  double velocity_mm_s = 0;  ///< at its end
  double thrust_n = 0;       ///< that the hand aims at
  double hand_force_n = 0;   ///< that it exerts: less where the feed is limited or the tool stands
  double hand_power_w = 0;
  double drill_power_w = 0;  ///< against the spin torque
};

/// The results of frame k, over the time (k−1, k]. Forces are those of the bone on the tool, in B.
struct FrameResult {
  std::int64_t frame = 0;
  int pass = 1;  ///< number of the tool's pass
  double time_s = 0;
  ToolPose pose;                   ///< at the end of the frame
  double depth_mm = 0;             ///< travel along −z of T since first contact of the pass
  Vec3 force_n = Vec3::Zero();     ///< mean over the substeps
  Vec3 torque_nmm = Vec3::Zero();  ///< about the tool's origin
  double axial_force_n = 0;        ///< along +z of T
  double spin_torque_nmm = 0;      ///< resistance to the spin: positive while cutting
  std::int64_t contacts = 0;       ///< voxels touched; of `erosion: exact` those that lost bone
  double removed_mm3 = 0;
  double energy_mj = 0;
  double floor_energy_mj = 0;
  double balance = 0;                   ///< (work done − energy cut)/energy cut, cumulative; 0 before contact
  std::optional<PushResult> push = {};  ///< of a tool that a hand pushes
  /// A tool on springs: from the planned position, in T.
  std::optional<Vec3> deflection_mm = {};

  /// Bone exerts a force on the tool, or the tool removes bone. Edges that rub do the first alone.
  [[nodiscard]] bool in_contact() const { return contacts > 0 || !force_n.isZero(0); }
};

/// What the voxels of one grade exert on the tool in a frame, per specific energy of 1 N/mm²; a row of force_basis.npy
/// (docs/columns.md). Force = Σ u·(P + k_n·N), in B. Grade 0 is the edge force: P per K_t, N per K_n, each 1 N/mm.
struct BasisRow {
  std::int32_t frame = 0;
  std::int32_t grade = 0;
  float density_g_cm3 = 0;
  float p_mm2[3] = {};
  float p_torque_mm3[3] = {};
  float n_mm2[3] = {};
  float n_torque_mm3[3] = {};
  float p_work_mm3 = 0;  ///< work on the bone
  float n_work_mm3 = 0;
  float energy_mm3 = 0;
  float floor_energy_mm3 = 0;
};
/// Its values from p_mm2 on.
inline constexpr std::size_t kBasisRowValues = 16;

/// Times of the stages of a frame: broad phase on the host, detect and cut on the device.
struct FrameTimes {
  double broad_phase_s = 0;
  double detect_s = 0;
  double cut_s = 0;

  FrameTimes& operator+=(const FrameTimes& other) {
    broad_phase_s += other.broad_phase_s;
    detect_s += other.detect_s;
    cut_s += other.cut_s;
    return *this;
  }
};

/// Receives the results of a run frame by frame. What it does not override it does not need.
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  virtual void frame(const FrameResult& /*result*/, const FrameTimes& /*times*/) {}
  /// The force basis of the frame that frame() received last, with `output.force_basis`; ascending grades.
  virtual void basis(const std::vector<BasisRow>& /*rows*/) {}
  /// The fill of the bone after `frame`. The sink may take its changes since the last call.
  virtual void snapshot(std::int64_t /*frame*/, FillBricks& /*fill*/) {}
  virtual void removed(const RemovedFrames& /*voxels*/) {}
};

}  // namespace reamsim
