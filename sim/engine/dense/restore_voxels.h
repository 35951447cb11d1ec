#pragma once

#include <vector>

#include "sim/bone/vdb/bone_vdb.h"
#include "sim/device/opencl.h"

namespace reamsim {

/// Puts single voxels of dense arrays back, so that a benchmark need not upload the whole bone before each repetition.
class VoxelRestorer {
 public:
  /// A voxel's index and its value; of a float, its bits.
  struct Entry {
    cl_uint voxel;
    cl_uint value;
  };

  explicit VoxelRestorer(const cl::Device& device);
  /// Writes the entries into an array of 8, 16 or 32 bits a voxel. Returns when the device has done it.
  template <class T>
  void put(const std::vector<Entry>& entries, const cl::Buffer<T>& values) {
    static_assert(sizeof(T) == 1 || sizeof(T) == 2 || sizeof(T) == 4);
    put(entries, values.get(), sizeof(T) == 1 ? bytes_ : sizeof(T) == 2 ? halves_ : words_);
  }

 private:
  void put(const std::vector<Entry>& entries, cl_mem values, cl::Kernel& kernel);

  const cl::Device& device_;
  cl::Program program_;
  cl::Kernel bytes_, halves_, words_;
};

/// The voxels of `gone` with what `value` says of (voxel index).
template <class Value>
std::vector<VoxelRestorer::Entry> entries_to_put_back(const RemovedFrames& gone, Value value) {
  std::vector<VoxelRestorer::Entry> entries;
  entries.reserve(gone.size());
  for (const auto& [voxel, frame] : gone) entries.push_back({static_cast<cl_uint>(voxel), value(voxel)});
  return entries;
}

}  // namespace reamsim
