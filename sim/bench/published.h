// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>

#include "kernels/published.h"
#include "sim/bench/program.h"

namespace reamsim::bench {

/// The arguments of the published kernels for a substep, in shell cells and voxels. `voi` in T, mm; without it the
/// whole shell. Throws InputError unless the bone is a cube.
PublishedFrame published_frame(const Substep& substep, const std::optional<Aabb>& voi, const Tool& tool,
                               const VoxelGrid& grid);

/// For each level of the descent through a cube of 2^n voxels along an edge, and each octant: its offset in the index
/// of a voxel. Throws InputError where the edge is no power of two.
std::vector<cl_uint> descent_steps(int side);

/// Work-items per group of the published kernels.
inline constexpr std::size_t kPublishedGroup = 256;

/// A published program. Before a frame that is prepared it records the voxels that the frame will remove, so that
/// restore() need not upload the whole bone.
class PublishedProgram : public Program {
 public:
  void prepare(const Substep& frame) override;
  BatchSample run(std::span<const Substep> frames, bool use_voi) override;
  void restore() override;
  [[nodiscard]] const Label& label() const override { return label_; }

 protected:
  /// `record_words`: 32-bit words that the kernel `published_touched` writes per point.
  PublishedProgram(const std::string& engine, const cl::DeviceInfo& info, const BenchSetup& setup, const char* source,
                   std::size_t record_words);
  /// Sets the arguments of the kernels that record and restore: the shell, what they test, and what they restore.
  template <class Shell, class Bone, class State>
  void set_restoring(const cl::Buffer<Shell>& shell, const cl::Buffer<Bone>& bone, const cl::Buffer<State>& state) {
    touched_kernel_.set_from(0, shell, static_cast<cl_uint>(points_), frame_, bone, touched_, touched_count_);
    restore_kernel_.set(0, touched_);
    restore_kernel_.set(2, state);
  }
  virtual void run_one(const Substep& frame, bool use_voi, BatchSample& sample) = 0;
  /// Restores the whole bone.
  virtual void restore_all() = 0;

  BenchSetup setup_;
  cl::Device device_;
  cl::Program program_;
  std::size_t points_;
  cl::Buffer<PublishedFrame> frame_;

 private:
  Label label_;
  cl::Kernel touched_kernel_, restore_kernel_;
  cl::Buffer<cl_uint> touched_;
  cl::Buffer<cl_uint> touched_count_;
  cl_uint recorded_ = 0;
  bool prepared_ = false;  ///< the changes of the next frame are recorded
  bool changed_ = false;   ///< by more than what is recorded
};

}  // namespace reamsim::bench
