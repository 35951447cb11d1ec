// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "sim/bone/vdb/bone_vdb.h"
#include "sim/device/opencl.h"

namespace reamsim {

/// Restores single voxels of dense arrays, so that a benchmark need not upload the whole bone before each repetition.
class VoxelRestorer {
 public:
  /// A voxel's index and its value, the bits of a float.
  struct Entry {
    cl_uint voxel;
    cl_uint value;
  };

  explicit VoxelRestorer(const cl::Device& device);
  /// Writes the entries into an array of 8, 16 or 32 bits per voxel, and waits for the device.
  template <class T>
  void write(const std::vector<Entry>& entries, const cl::Buffer<T>& values) {
    static_assert(sizeof(T) == 1 || sizeof(T) == 2 || sizeof(T) == 4);
    write(entries, values.get(), sizeof(T) == 1 ? bytes_ : sizeof(T) == 2 ? halves_ : words_);
  }

 private:
  void write(const std::vector<Entry>& entries, cl_mem values, cl::Kernel& kernel);

  const cl::Device& device_;
  cl::Program program_;
  cl::Kernel bytes_, halves_, words_;
};

/// The voxels of `removed` with value(voxel index).
template <class Value>
std::vector<VoxelRestorer::Entry> entries_to_restore(const RemovedFrames& removed, Value value) {
  std::vector<VoxelRestorer::Entry> entries;
  entries.reserve(removed.size());
  for (const auto& [voxel, frame] : removed) entries.push_back({static_cast<cl_uint>(voxel), value(voxel)});
  return entries;
}

}  // namespace reamsim
