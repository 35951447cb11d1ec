// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "kernels/window.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/device/opencl.h"
#include "sim/engine/common/substep.h"
#include "sim/scenario/scenario.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// The values of a basis: force (3) and torque (3) against the motion, force (3) and torque (3) along the normal,
/// energy, speed-floor energy.
inline constexpr std::size_t kBasisValues = 14;

/// What the voxels of one grade exert on the tool in one substep, per specific energy of 1 N/mm² = 1 mJ/mm³
/// (docs/physics.md, 4): force = u·(P + k_n·N). In T without spin. Grade 0 is the edge force: P per K_t, N per K_n.
struct GradeBasis {
  int grade = 0;
  std::array<double, kBasisValues> values{};

  [[nodiscard]] Vec3 force() const { return at(0); }                ///< P, mm²
  [[nodiscard]] Vec3 torque() const { return at(3); }               ///< P, mm³
  [[nodiscard]] Vec3 normal_force() const { return at(6); }         ///< N, mm²
  [[nodiscard]] Vec3 normal_torque() const { return at(9); }        ///< N, mm³
  [[nodiscard]] double energy() const { return values[12]; }        ///< mm³
  [[nodiscard]] double floor_energy() const { return values[13]; }  ///< mm³

 private:
  [[nodiscard]] Vec3 at(std::size_t first) const { return {values[first], values[first + 1], values[first + 2]}; }
};

/// The grades that lose volume in a substep, ascending.
using SubstepBasis = std::vector<GradeBasis>;

/// Run times of a substep: detection of voxels or bricks in reach, and cut.
struct StageTimes {
  double detect_s = 0;
  double cut_s = 0;
};

/// Results of the substeps of a batch, in the order of enqueue().
struct Batch {
  std::vector<SubstepSums> sums;
  std::vector<StageTimes> times;
  std::vector<SubstepBasis> basis{};  ///< with `output.force_basis`; else empty
};

/// Device memory of bone and tool, bytes: the structures of the paper's Table 4, without those of a batch.
struct StructureBytes {
  std::size_t voxmap = 0;
  std::size_t shell = 0;
};

/// Moves the tool through its own copy of the bone, substep by substep: removes bone, and sums forces and energy.
class Engine {
 public:
  virtual ~Engine() = default;
  /// Adds a substep to the batch, which must not be full. It is executed at any time until collect() returns. `window`:
  /// of smooth motion that the substep belongs to, for `exact`; nullptr: none.
  virtual void enqueue(const SubstepArgs& args, std::shared_ptr<const MotionWindow> window) = 0;
  void enqueue(const SubstepArgs& args) { enqueue(args, nullptr); }
  /// Whether another substep might not fit; collect() empties the batch.
  [[nodiscard]] virtual bool full() const = 0;
  /// Finishes the batch, and returns its results.
  virtual Batch collect() = 0;
  /// The voxels that the last collected batch removed, and their frames. The next enqueue() clears them.
  virtual RemovedFrames take_removed() = 0;
  /// Updates partly removed voxels in `fill`; those without fill are in take_removed(). `voxmap`: that of the engine.
  virtual void read_fill(const Voxmap& voxmap, FillBricks& fill) = 0;
  /// Sets the bone; all batches must have been collected. Throws RunError for another voxmap than the engine's.
  virtual void restore(const BoneView& bone) = 0;
  /// As restore(), for the voxels of `removed` only, where the engine supports that.
  virtual void restore_voxels(const BoneView& bone, const RemovedFrames& /*removed*/) { restore(bone); }
  /// Name of the device, or "serial".
  [[nodiscard]] virtual std::string device() const = 0;
  /// Device memory of the bone, the tool, the batch and its lists, bytes.
  [[nodiscard]] virtual std::size_t device_bytes() const = 0;
  [[nodiscard]] virtual StructureBytes structure_bytes() const = 0;
};

/// The devices of engines that run one after another: each is opened, and its kernels are compiled, once.
class EngineDevices {
 public:
  /// The device that the scenario asks for. Throws InputError (no such device, a work-group too large for it) or
  /// RunError (no OpenCL).
  cl::Device of(const EngineSettings& engine);

 private:
  std::map<std::pair<std::string, int>, cl::Device> opened_;  ///< by name and compute units as the scenario has them
};

/// The engine that the scenario asks for. Throws InputError (no such device, bone too large) or RunError (no OpenCL, a
/// kernel that does not build). `devices`: opened before, or to be opened for later engines as well.
std::unique_ptr<Engine> make_engine_on(EngineDevices& devices, const Scenario& scenario, const BoneView& bone,
                                       const Tool& tool);
/// The same on a device of its own.
std::unique_ptr<Engine> make_engine(const Scenario& scenario, const BoneView& bone, const Tool& tool);

// Each engine by itself.

/// The engines with a dense array of voxels (`direct`, `octree`, `implicit`).
std::unique_ptr<Engine> make_dense_engine(const cl::Device& device, const Scenario& scenario, const BoneView& bone,
                                          const Tool& tool);

/// The reference of all engines, in plain C++ without OpenCL.
std::unique_ptr<Engine> make_serial_engine(const Scenario& scenario, const BoneView& bone, const Tool& tool);

/// An engine whose batches have the force basis as well (`output.force_basis`). `engine` does everything else, and its
/// results are the same as alone. It must be `exact`, or one that removes touched voxels whole. `tool` and the voxmap
/// must outlive it.
std::unique_ptr<Engine> make_basis_engine(std::unique_ptr<Engine> engine, const Scenario& scenario,
                                          const BoneView& bone, const Tool& tool);

/// Bounds of what a run does to the bone's bricks.
struct ExactForecast {
  std::size_t partial = 0;  ///< bricks that are partly removed or that the tool reaches: a page of fill each
  std::size_t listed = 0;   ///< bricks that the tool's surface can intersect in one visit
};

/// `erosion: exact` over bricks. Throws InputError when the bone does not fit.
std::unique_ptr<Engine> make_exact_engine(const cl::Device& device, const Scenario& scenario, const BoneView& bone,
                                          const Tool& tool);

/// Bound of the engine's device memory, bytes.
std::size_t exact_engine_bytes(const BoneView& bone, const Tool& tool, const ExactForecast& forecast);

/// Buffer sizes of `bricked`, which tests reduce. Results do not depend on them.
struct BrickedLimits {
  std::size_t largest_pool = SIZE_MAX;   ///< bytes of one buffer of bricks
  std::size_t removed_room = 1'000'000;  ///< records in a batch's list of removed voxels; one substep always fits
};

/// The `bricked` engine on `device`. Throws InputError when the bone does not fit.
std::unique_ptr<Engine> make_bricked_engine(const cl::Device& device, const Scenario& scenario, const BoneView& bone,
                                            const Tool& tool, const BrickedLimits& limits = {});

/// Device memory that make_bricked_engine() would take, bytes.
std::size_t bricked_engine_bytes(const Scenario& scenario, const BoneView& bone, const Tool& tool);

}  // namespace reamsim
