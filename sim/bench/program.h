#pragma once

#include <memory>
#include <span>
#include <string>

#include "sim/bench/scene.h"
#include "sim/device/opencl.h"
#include "sim/engine/common/broad_phase.h"
#include "sim/engine/common/engine.h"

namespace reamsim::bench {

/// What a frame meets: the bone, the tool and their boxes. The voxmap and the tool are the caller's.
struct Setup {
  const FilledVoxmap* voxmap = nullptr;
  const Tool* tool = nullptr;
  Aabb bone_box;  ///< B, mm
  Aabb tool_box;  ///< T, mm
};

/// Which program runs the frame.
struct Label {
  std::string engine;   ///< bricked | direct | octree | implicit
  std::string variant;  ///< deterministic: as `reamsim run` does it | published: the paper's racing pass
};

/// What a batch of frames took and found; seconds of wall time unless said otherwise.
struct BatchSample {
  double total_s = 0;         ///< broad phase, arguments, kernels and results read
  double broad_s = 0;         ///< of it: boxes and VOI
  double upload_s = 0;        ///< of it: arguments made and sent, kernels enqueued
  double kernel_s = 0;        ///< of it: kernels, by the device's clock
  std::int64_t voxels = 0;    ///< that lost something; 0 where the program does not count them
  double removed = 0;         ///< voxels that went, partly gone ones as shares; 0 where the program does not count
  std::int64_t contacts = 0;  ///< points of a published program that counts them
  Vec3 force = Vec3::Zero();  ///< an engine: N, in T; a published program: elemental forces, in B
};

/// A program that collides and cuts, set up on one setup. Frames change its bone until restore().
class Program {
 public:
  virtual ~Program() = default;
  /// Called before run(frame) on whole bone: a program that cannot say which voxels went finds out here. Not timed.
  virtual void prepare(const Substep& /*frame*/) {}
  /// Runs substeps as frames, enqueued at once where the program can, and reads what they gave. `use_voi` false: the
  /// whole shell is tested.
  virtual BatchSample run(std::span<const Substep> frames, bool use_voi) = 0;
  /// Puts the bone back. Not timed.
  virtual void restore() = 0;
  [[nodiscard]] virtual StructureBytes bytes() const = 0;
  [[nodiscard]] virtual const Label& label() const = 0;
};

/// `reamsim run`'s own engine on the device. Throws what make_engine() throws.
std::unique_ptr<Program> make_engine_program(const std::string& engine, const std::string& device, const Setup& setup,
                                             ErosionMode erosion = ErosionMode::remove);

/// The published program of an engine. `count`: count contacts, at the price of one more atomic sum a point. Throws
/// RunError when the device has no room.
std::unique_ptr<Program> make_published_direct(const cl::DeviceInfo& device, const Setup& setup, bool count);
/// Needs a cube of 2^n voxels an edge. Always counts.
std::unique_ptr<Program> make_published_octree(const cl::DeviceInfo& device, const Setup& setup);

}  // namespace reamsim::bench
