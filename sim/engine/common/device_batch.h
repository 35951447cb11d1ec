#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "kernels/shared.h"
#include "sim/device/opencl.h"

namespace reamsim {

/// A voxel that went, as the kernels over dense arrays write it: one word.
struct RemovedVoxel {
  cl_uint voxel;  ///< its index
  cl_uint frame;
};

/// Substeps that a batch holds at most.
inline constexpr int kMaxSlots = 4096;

/// The slots of a batch of substeps on the device: arguments, sums and the number of contacts of each, and one list of
/// what went in any of them. It knows nothing of how the bone is stored, so that every engine can use it.
class DeviceBatch {
 public:
  /// The list of what went: entries of `words` 64-bit words. `room`: entries. `per_substep`: most that one substep can
  /// make. `in_all`: most that a batch can make however long it is; where the list holds them it never runs over.
  /// `resumes`: kernels leave alone what the list might not hold, and the engine resumes there; otherwise a batch is so
  /// short that this cannot happen.
  struct RemovedList {
    std::size_t words = 1;
    std::size_t room = 0;
    std::size_t per_substep = 0;
    std::size_t in_all = 0;
    bool resumes = false;
  };

  /// Throws RunError when the device has no room.
  DeviceBatch(const cl::Device& device, const RemovedList& removed);

  /// Sends a substep's arguments to the next slot, and returns the slot. The device must outlive the batch.
  int begin(const SubstepArgs& args);
  /// The arguments that begin() took into a slot of this batch.
  [[nodiscard]] const SubstepArgs& args_of(int slot) const { return host_args_[static_cast<std::size_t>(slot)]; }
  /// The arguments of the batch's substeps, by slot.
  [[nodiscard]] std::span<const SubstepArgs> args_used() const {
    return {host_args_.data(), static_cast<std::size_t>(used_)};
  }
  /// True when another substep might not find room.
  [[nodiscard]] bool full() const { return used_ >= slots_; }

  /// Substeps in the batch.
  [[nodiscard]] int used() const { return used_; }

  /// Waits. The first substep that waits for room in the list of what went (its contacts are negative, and nothing has
  /// been cut in it or after it), or -1.
  int stalled();
  /// Gives the list to the caller and its room to the substep `slot`, the one that stalled() named: it is to be cut,
  /// and those after it are to be detected and cut.
  std::vector<cl_ulong> make_room(int slot);

  /// Waits for every substep of the batch, hands their sums over by slot, and empties the batch.
  std::vector<SubstepSums> collect();
  /// The list of the batch that was collected last, as the kernels wrote it, in no particular order. What is not taken
  /// before the next begin() is dropped.
  std::vector<cl_ulong> take_removed();

  /// Device memory that a batch takes, bytes.
  static std::size_t bytes(const RemovedList& removed);

  [[nodiscard]] const cl::Buffer<SubstepArgs>& args() const { return args_; }
  [[nodiscard]] const cl::Buffer<SubstepSums>& sums() const { return sums_; }
  [[nodiscard]] const cl::Buffer<cl_uint>& contact_count() const { return contact_count_; }  ///< per slot, 0 on entry
  [[nodiscard]] const cl::Buffer<cl_ulong>& removed() const { return removed_; }
  [[nodiscard]] const cl::Buffer<cl_uint>& removed_count() const { return removed_count_; }
  [[nodiscard]] const cl::Buffer<cl_uint>& removed_before() const { return removed_before_; }  ///< per slot
  [[nodiscard]] cl_uint2 removed_room() const { return room_; }  ///< entries of the list, and most of one substep

 private:
  void read_sums();

  const cl::Device& device_;
  cl::Buffer<SubstepArgs> args_;
  cl::Buffer<SubstepSums> sums_;
  cl::Buffer<cl_uint> contact_count_;
  cl::Buffer<cl_ulong> removed_;
  std::size_t removed_words_;
  cl::Buffer<cl_uint> removed_count_;
  cl::Buffer<cl_uint> removed_before_;
  cl_uint2 room_;
  std::vector<SubstepSums> host_sums_;  // of the batch, once the queue has finished
  std::vector<SubstepArgs> host_args_;  // lives until the non-blocking write is done
  int slots_ = kMaxSlots;
  int used_ = 0;
  bool removed_waits_ = false;
};

}  // namespace reamsim
