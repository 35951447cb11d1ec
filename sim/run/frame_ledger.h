#pragma once

#include <optional>
#include <vector>

#include "sim/engine/common/substep.h"
#include "sim/record/results.h"

namespace reamsim {

/// A frame whose substeps are with the engine.
struct PendingFrame {
  std::int64_t frame = 0;
  ToolPose before;  ///< pose at the start of the frame
  ToolPose pose;    ///< pose at its end
  int substeps = 1;
  std::vector<std::pair<std::size_t, Substep>>
      cut;  ///< (place in the batch, substep) of those that the broad phase let through
  double broad_phase_s = 0;
};

/// Turns the integer sums of the substeps into the rows of forces.csv, and keeps the energy account: the work done on
/// the bone, −Σ(T·ω + F·v)·Δt + E_floor, against the energy of the volume cut, accumulated apart (design §5).
class FrameLedger {
 public:
  /// `sums_turn`: the sums of a substep are in the shell's frame, which turns with the teeth (law per_point, spin
  /// resolved), and not in the tool's without spin.
  FrameLedger(double voxel_mm3, double frame_s, bool sums_turn)
      : voxel_mm3_(voxel_mm3), frame_s_(frame_s), sums_turn_(sums_turn) {}

  FrameResult close(const PendingFrame& frame, const std::vector<SubstepSums>& sums);

  /// (work − cut)/cut so far; 0 before contact.
  [[nodiscard]] double balance() const { return cut_mj_ > 0 ? (work_mj_ + floor_mj_ - cut_mj_) / cut_mj_ : 0; }

 private:
  double voxel_mm3_;
  double frame_s_;
  bool sums_turn_;
  double work_mj_ = 0;
  double floor_mj_ = 0;
  double cut_mj_ = 0;
  std::optional<Vec3> first_contact_mm_;  ///< of the tool's origin, B
};

}  // namespace reamsim
