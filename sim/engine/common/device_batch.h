// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "kernels/bricks.h"
#include "kernels/shared.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/device/opencl.h"
#include "sim/engine/common/engine.h"

namespace reamsim {

/// A removed voxel as the kernels over dense arrays write it: one word.
struct RemovedVoxel {
  cl_uint voxel;  ///< its index
  cl_uint frame;
};

/// The largest number of substeps in a batch.
inline constexpr int kMaxSlots = 4096;

/// A batch of substeps on the device: arguments, sums and number of contacts per slot, and one list of removed voxels.
/// Independent of the storage of the bone.
class DeviceBatch {
 public:
  /// The list of removed voxels.
  struct RemovedList {
    std::size_t words = 1;        ///< 64-bit words per entry
    std::size_t room = 0;         ///< entries
    std::size_t per_substep = 0;  ///< most entries of one substep
    std::size_t in_total = 0;     ///< most entries of a batch of any length
    bool resumes = false;         ///< kernels stop before an overflow and the engine resumes; else batches are shorter
  };

  /// Throws InputError when the device runs out of memory. The device must outlive the batch.
  DeviceBatch(const cl::Device& device, const RemovedList& removed);

  /// Takes a substep's arguments into the next slot, and returns the slot. write_args() writes those of all slots.
  int add(const SubstepArgs& args);
  void write_args();
  /// Writes a substep's arguments to the next slot, and returns the slot.
  int begin(const SubstepArgs& args);
  /// By slot.
  [[nodiscard]] std::span<const SubstepArgs> args_used() const {
    return {host_args_.data(), static_cast<std::size_t>(used_)};
  }
  /// Whether another substep might not fit.
  [[nodiscard]] bool full() const { return used_ >= slots_; }

  /// Number of substeps.
  [[nodiscard]] int used() const { return used_; }

  /// Finishes the queue. Returns the first substep that waits for room in the list of removed voxels, or -1. It and
  /// those after it have cut nothing.
  int first_waiting();
  /// Empties the list, and returns it. The caller then cuts substep `slot`, and detects and cuts those after it.
  std::vector<cl_ulong> make_room(int slot);

  /// Finishes the queue, returns the sums by slot, and empties the batch.
  std::vector<SubstepSums> collect();
  /// The list of removed voxels of the last batch, in no particular order. The next begin() clears it.
  std::vector<cl_ulong> take_removed();

  /// Appends the voxels of a block that a substep of the batch removed.
  void append_removed(const RemovedBlock& block, const VoxelGrid& grid, RemovedFrames& removed) const;

  /// Device memory of a batch, bytes.
  static std::size_t bytes(const RemovedList& removed);

  [[nodiscard]] const cl::Buffer<SubstepArgs>& args() const { return args_; }
  [[nodiscard]] const cl::Buffer<SubstepSums>& sums() const { return sums_; }
  [[nodiscard]] const cl::Buffer<cl_uint>& contact_count() const { return contact_count_; }  ///< per slot, 0 on entry
  [[nodiscard]] const cl::Buffer<cl_ulong>& removed() const { return removed_; }
  [[nodiscard]] const cl::Buffer<cl_uint>& removed_count() const { return removed_count_; }
  [[nodiscard]] const cl::Buffer<cl_uint>& removed_before() const { return removed_before_; }  ///< per slot
  [[nodiscard]] cl_uint2 removed_room() const { return room_; }                                ///< room, per_substep

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
  std::vector<SubstepSums> host_sums_;  // once the queue has finished
  std::vector<SubstepArgs> host_args_;  // lives until the non-blocking write is done
  int slots_ = kMaxSlots;
  int used_ = 0;
  bool has_removed_ = false;  // the list is that of the last batch
};

/// The times of two stages since the last call, by slot.
std::vector<StageTimes> stage_times(cl::SlotKernel& detect, cl::SlotKernel& cut);

/// Copies every fill of a dense array (an entry per voxel, in the order of VoxelGrid::index) that is not whole into
/// `fill`. Air is unchanged.
void copy_fill(const std::vector<std::uint16_t>& dense, const Voxmap& voxmap, FillBricks& fill);

}  // namespace reamsim
