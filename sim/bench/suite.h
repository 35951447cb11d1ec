// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sim/run/simulation.h"

namespace reamsim::bench {

/// Median with its spread over all poses and repetitions, in the unit of the owner.
struct Spread {
  double median = 0;
  double min = 0;
  double max = 0;
  int samples = 0;
};
Spread spread_of(const std::vector<double>& values);

/// Operations of exact erosion for a voxel that loses bone in a frame of a window, a fused multiply-add as two: 36 for
/// its loss (rs_window_outside() with two pieces and rs_clip_loss()) and 32 for force, torque and energies
/// (kernels/cut_window.h).
inline constexpr double kExactOperations = 68;
/// Memory that it needs, bytes: fill read and written, and grade read, once in a window of 64 frames.
inline constexpr double kExactBytes = 5.0 / 64;

/// Names a program.
struct Label {
  std::string engine;   ///< bricked | direct | octree | implicit
  std::string variant;  ///< deterministic: that of `reamsim run` | published: the paper's racing pass

  bool operator==(const Label&) const = default;
};
inline std::string name_of(const Label& who) {
  return who.engine + (who.variant == "published" ? ", published" : "");
}

/// The benchmark's report (docs/columns.md): what was measured, as rows.
using Json = nlohmann::ordered_json;

/// The row of a case in the results of a report, or nullptr.
const Json* find_result(const Json& report, const Label& who, int voxmap, int shell, const std::string& contact);
/// The report as text tables, with the paper's figures.
std::string text_of(const Json& report);

/// Sizes of voxmap and shell, cells along an edge.
struct SizePair {
  int voxmap = 0;
  int shell = 0;
};

/// What to measure.
struct Plan {
  std::string device = "auto";
  std::vector<std::string> engines;
  std::vector<SizePair> sizes;  ///< by ascending voxmap; the last pair gets every part below
  int sampled = 256;            ///< voxels an edge at which the phantom is sampled
  int repetitions = 5;          ///< of each pose, after a warm-up
  bool verify_poses = true;     ///< an error where contacts of the last pair differ by more than 5 %
  bool light = true;            ///< the case `light`, wherever the shell is the last pair's
  bool details = true;          ///< VOI curve, batches, plunge, scatter
  int plunge_frames = 1000;
  std::vector<double> sphere_voxels_mm{0.25, 0.1, 0.04};  ///< of the plunged sphere
};

/// All engines: `exact`, then those of `remove`, fastest first.
const std::vector<std::string>& engine_names();
Plan full_plan();    ///< all of the paper's tables; eleven minutes on two cores
Plan quick_plan();   ///< `severe` and `none` at 256³ and 1024³ for `exact`, `bricked` and `direct`; a minute
Plan sphere_plan();  ///< the plunged sphere with `erosion: exact` alone; half a minute

/// Progress, and the request to stop.
struct BenchControl {
  /// Called at the beginning of a step, with the fraction of the usual time that lies behind.
  std::function<void(double, const std::string&)> part = [](double, const std::string&) {};
  std::function<bool()> stop = [] { return false; };
};

/// Throws InputError where the plan names an engine or a device that does not exist, RunError where there is no OpenCL.
void check_plan(const Plan& plan);
/// Runs the plan. Throws InputError (no such engine or device), RunError (no OpenCL; wrong number of touching points),
/// Interrupted. Programs that the device cannot hold are in its list `skipped`.
Json run_bench(const Plan& plan, const BenchControl& control);

/// The first frames in contact are left out: caches and clocks of the processor are not as they will be.
inline constexpr std::size_t kWarmUpFrames = 20;

/// Wall time of a frame alone: pose in, force out, nothing batched and no windows, as a haptic device needs it.
struct Latency {
  std::int64_t frames = 0;  ///< in contact, that were timed
  double median_ms = 0;
  double p99_ms = 0;
  double p999_ms = 0;
  double most_ms = 0;
};

/// Moves the tool of the scene along its motion frame by frame, and times those in contact but the first 20, in which
/// memory of the device grows. Ends after `most` of them. Throws Interrupted, RunError.
Latency frame_latency(SimulationInput& scene, Engine& engine, std::int64_t most, const std::function<bool()>& stop);

}  // namespace reamsim::bench
