#pragma once

#include <cstddef>
#include <vector>

#include "kernels/shared.h"
#include "sim/device/opencl.h"

namespace reamsim {

/// A voxel that went, as the kernels write it. What the number means is the engine's affair: in a dense array it is the
/// voxel's index.
struct RemovedVoxel {
  cl_uint voxel;
  cl_uint frame;
};

/// Substeps that a batch holds at most.
inline constexpr int kMaxSlots = 4096;

/// The slots of a batch of substeps on the device: arguments, sums and the number of contacts of each, and one list of
/// the voxels that went in any of them. It knows nothing of how the bone is stored, so that every engine can use it.
class DeviceBatch {
 public:
  /// `removed_room`: entries of the list of removed voxels. `removed_per_substep`: most voxels that can go in one
  /// substep. `removed_in_all`: most voxels that can go at all; where the list holds them it never runs over.
  /// Throws RunError when the device has no room.
  DeviceBatch(const cl::Device& device, std::size_t removed_room, std::size_t removed_per_substep,
              std::size_t removed_in_all);

  /// Sends a substep's arguments to the next slot, and returns the slot. The device must outlive the batch.
  int begin(const SubstepArgs& args);
  /// The arguments that begin() took into a slot of this batch.
  [[nodiscard]] const SubstepArgs& args_of(int slot) const { return host_args_[static_cast<std::size_t>(slot)]; }
  /// True when another substep might not find room.
  [[nodiscard]] bool full() const { return used_ >= slots_; }

  struct Results {
    std::vector<SubstepSums> sums;      ///< by slot
    std::vector<RemovedVoxel> removed;  ///< in no particular order
  };
  /// Waits for every substep of the batch, hands its results over and empties the batch.
  Results collect();

  /// Device memory that a batch takes, bytes.
  static std::size_t bytes(std::size_t removed_room);

  [[nodiscard]] const cl::Buffer<SubstepArgs>& args() const { return args_; }
  [[nodiscard]] const cl::Buffer<SubstepSums>& sums() const { return sums_; }
  [[nodiscard]] const cl::Buffer<cl_uint>& contact_count() const { return contact_count_; }  ///< per slot, 0 on entry
  [[nodiscard]] const cl::Buffer<RemovedVoxel>& removed() const { return removed_; }
  [[nodiscard]] const cl::Buffer<cl_uint>& removed_count() const { return removed_count_; }

 private:
  void clear(std::size_t slots);

  const cl::Device& device_;
  cl::Buffer<SubstepArgs> args_;
  cl::Buffer<SubstepSums> sums_;
  cl::Buffer<cl_uint> contact_count_;
  cl::Buffer<RemovedVoxel> removed_;
  cl::Buffer<cl_uint> removed_count_;
  std::vector<SubstepArgs> host_args_;  // lives until the non-blocking write is done
  int slots_ = kMaxSlots;
  int used_ = 0;
};

}  // namespace reamsim
