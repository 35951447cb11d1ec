#pragma once

#include <string>
#include <vector>

#include "sim/bone/vdb/bone_vdb.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/engine/common/substep.h"

namespace reamsim {

/// Seconds that a substep took: finding the voxels or bricks that the tool reaches, and cutting them.
struct StageTimes {
  double detect_s = 0;
  double cut_s = 0;
};

/// What the substeps of a batch gave, in the order in which they were enqueued.
struct Batch {
  std::vector<SubstepSums> sums;
  std::vector<StageTimes> times;
};

/// What an engine keeps of bone and tool on the device, bytes: the structures that the paper's Table 4 compares,
/// without the lists and slots of a batch.
struct StructureBytes {
  std::size_t voxmap = 0;
  std::size_t shell = 0;
};

/// Moves the tool through the bone, substep by substep, on a copy of the bone of its own: sums forces and energy, and
/// removes bone. Each engine's file names its stages.
class Engine {
 public:
  virtual ~Engine() = default;
  /// Takes the next substep of the batch. Its work may be done at any time until collect() returns. The batch must not
  /// be full.
  virtual void enqueue(const SubstepArgs& args) = 0;
  /// True when another substep might not find room; collect() empties the batch.
  [[nodiscard]] virtual bool full() const = 0;
  /// Finishes every substep of the batch, and hands its results over.
  virtual Batch collect() = 0;
  /// The voxels removed in the batch collected last, and when. What is not taken before the next enqueue() is dropped.
  virtual RemovedFrames take_removed() = 0;
  /// Brings fill that fell without reaching zero into `fill`; voxels removed whole are in take_removed(). `voxmap`:
  /// what the engine was made with.
  virtual void read_fill(const Voxmap& voxmap, FillBricks& fill) = 0;
  /// Sets the bone to `bone`, for benchmarks and tests; every batch must have been collected. Throws RunError where it
  /// is not the voxmap that the engine was made with, reamed or not.
  virtual void restore(const BoneView& bone) = 0;
  /// As restore(), for the voxels of `removed` only; an engine that knows no shorter way restores everything.
  virtual void restore_voxels(const BoneView& bone, const RemovedFrames& /*removed*/) { restore(bone); }
  /// Name of the device, or "serial".
  [[nodiscard]] virtual std::string device() const = 0;
  /// Device memory of the bone, the tool, the batch and its lists, bytes.
  [[nodiscard]] virtual std::size_t device_bytes() const = 0;
  [[nodiscard]] virtual StructureBytes structure_bytes() const = 0;
};

/// Times of two stages, each by slot.
inline std::vector<StageTimes> stage_times(const std::vector<double>& detect_s, const std::vector<double>& cut_s) {
  std::vector<StageTimes> out;
  for (std::size_t i = 0; i < cut_s.size(); ++i) out.push_back({detect_s[i], cut_s[i]});
  return out;
}

}  // namespace reamsim
