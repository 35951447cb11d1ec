// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/bench/findings.h"

namespace reamsim::bench {

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
/// All of the paper's tables; eleven minutes on two cores.
Plan full_plan();
/// `severe` and `none` at 256³ and 1024³ for `exact`, `bricked` and `direct`; a minute.
Plan quick_plan();

/// The plunged sphere with `erosion: exact` alone; half a minute.
Plan sphere_plan();

/// Progress, and the request to stop.
struct BenchControl {
  /// Called at the beginning of a step, with the fraction of the usual time that lies behind.
  std::function<void(double, const std::string&)> part = [](double, const std::string&) {};
  std::function<bool()> stop = [] { return false; };
};

/// Throws InputError where the plan names an engine or a device that does not exist, RunError where there is no OpenCL.
void check_plan(const Plan& plan);
/// Runs the plan. Throws InputError (no such engine or device), RunError (no OpenCL; wrong number of touching points),
/// Interrupted. Programs that the device cannot hold are in Findings::skipped.
Findings run_bench(const Plan& plan, const BenchControl& control);

/// Depths of the approaches for a voxmap and a shell, as text for scene.cpp.
std::string find_depths(int voxmap, int shell);

}  // namespace reamsim::bench
