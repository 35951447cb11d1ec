#pragma once

#include <string>
#include <vector>

#include "sim/bone/vdb/bone_vdb.h"
#include "sim/engine/common/detector.h"
#include "sim/engine/common/erosion.h"
#include "sim/engine/common/substep.h"

namespace reamsim {

/// What a batch of substeps gave, by slot.
struct Batch {
  std::vector<SubstepSums> sums;
  std::vector<double> detect_s;
  std::vector<double> cut_s;
};

/// What an engine keeps of bone and tool on the device, bytes: the structures that the paper's Table 4 compares,
/// without the lists and slots of a batch.
struct StructureBytes {
  std::size_t voxmap = 0;
  std::size_t shell = 0;
};

/// A detector and an erosion that work on one copy of the bone, with the slots of a batch of substeps.
class Engine {
 public:
  virtual ~Engine() = default;
  /// Takes a substep's arguments into the next slot, and returns the slot.
  virtual int begin(const SubstepArgs& args) = 0;
  virtual Detector& detector() = 0;
  virtual Erosion& erosion() = 0;
  /// True when another substep might not find room; collect() empties the batch.
  [[nodiscard]] virtual bool full() const = 0;
  /// Waits for every substep of the batch and hands its results over.
  virtual Batch collect() = 0;
  /// The voxels that went in the batch collected last, and when. What is not taken before the next begin() is dropped.
  virtual RemovedFrames take_removed() = 0;
  /// Brings fill that fell without reaching zero (`wear`) into `voxmap`; voxels that went are in take_removed().
  virtual void read_fill(Voxmap& voxmap) = 0;
  /// Puts the bone back as `voxmap` has it, for benchmarks and tests; every batch must have been collected. Throws
  /// RunError where it is not the voxmap that the engine was made with, reamed or not.
  virtual void restore(const Voxmap& voxmap) = 0;
  /// As restore(), for the voxels of `gone` only; an engine that knows no shorter way restores everything.
  virtual void restore_voxels(const Voxmap& voxmap, const RemovedFrames& /*gone*/) { restore(voxmap); }
  /// Name of the device, or "serial".
  [[nodiscard]] virtual std::string device() const = 0;
  [[nodiscard]] virtual std::size_t device_bytes() const = 0;
  [[nodiscard]] virtual StructureBytes structure_bytes() const = 0;
};

}  // namespace reamsim
