// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <memory>
#include <span>
#include <string>

#include "sim/bench/scene.h"
#include "sim/device/opencl.h"
#include "sim/engine/common/substep.h"
#include "sim/engine/make_engine.h"

namespace reamsim::bench {

/// The bone, the tool and their boxes. The caller owns voxmap and tool.
struct BenchSetup {
  const FilledVoxmap* voxmap = nullptr;
  const Tool* tool = nullptr;
  Aabb bone_box;  ///< B, mm
  Aabb tool_box;  ///< T, mm
};

/// Names a program.
struct Label {
  std::string engine;   ///< bricked | direct | octree | implicit
  std::string variant;  ///< deterministic: that of `reamsim run` | published: the paper's racing pass
};
inline std::string name_of(const Label& who) {
  return who.engine + (who.variant == "published" ? ", published" : "");
}

/// Times and results of a batch of frames; seconds of wall time unless stated otherwise.
struct BatchSample {
  double total_s = 0;         ///< broad phase, arguments, kernels and results read
  double broad_s = 0;         ///< of the total: boxes and VOI
  double upload_s = 0;        ///< of the total: arguments computed and sent, kernels enqueued
  double kernel_s = 0;        ///< of the total: kernels, by the clock of the device
  std::int64_t voxels = 0;    ///< that lost bone; 0 where the program does not count them
  double removed = 0;         ///< removed voxels, partial ones as fractions; 0 where the program does not count them
  std::int64_t contacts = 0;  ///< touching points, of a published program that counts them
  Vec3 force = Vec3::Zero();  ///< an engine: N, in T; a published program: elemental forces, in B
};

/// A program that detects contact and removes bone. Frames change its bone until restore().
class Program {
 public:
  virtual ~Program() = default;
  /// Called before run(frame) on whole bone. A program that cannot list removed voxels determines them here. Not timed.
  virtual void prepare(const Substep& /*frame*/) {}
  /// Runs substeps as frames, enqueued at once where the program can, and reads their results. `use_voi` false: tests
  /// the whole shell.
  virtual BatchSample run(std::span<const Substep> frames, bool use_voi) = 0;
  /// Restores the bone. Not timed.
  virtual void restore() = 0;
  [[nodiscard]] virtual StructureBytes bytes() const = 0;
  [[nodiscard]] virtual const Label& label() const = 0;
};

/// An engine of `erosion: remove` on the device. Throws what make_engine() throws.
std::unique_ptr<Program> make_engine_program(const std::string& engine, const std::string& device,
                                             const BenchSetup& setup);

/// The published program of an engine. `count`: count contacts, with one more atomic sum per point. Throws RunError
/// when the device has not enough memory.
std::unique_ptr<Program> make_published_direct(const cl::DeviceInfo& device, const BenchSetup& setup, bool count);
/// Needs a cube of 2^n voxels along each edge. Always counts.
std::unique_ptr<Program> make_published_octree(const cl::DeviceInfo& device, const BenchSetup& setup);

}  // namespace reamsim::bench
