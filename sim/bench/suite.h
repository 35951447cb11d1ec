#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/bench/findings.h"

namespace reamsim::bench {

/// A voxmap and a shell that meet, cells along an edge.
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
  int repetitions = 5;          ///< of each pose, after one that warms up
  bool verify_poses = true;     ///< an error when the severe or light contacts of the last pair are off by over 5 %
  bool light = true;            ///< the case `light`, wherever the shell is the last pair's
  bool details = true;          ///< VOI curve, batches, plunge, scatter
  int plunge_frames = 1000;
  std::vector<double> sphere_voxels_mm{0.25, 0.1, 0.04};
};

/// The engines that the bench knows, fastest first.
const std::vector<std::string>& engine_names();
/// The paper's tables in whole; about ten minutes on two cores.
Plan full_plan();
/// `severe` and `none` at 256³ and 1024³ for `direct` and `bricked`; under a minute.
Plan quick_plan();

/// What the caller may control and steer.
struct BenchControl {
  std::function<void(const std::string&)> progress = [](const std::string&) {};
  std::function<bool()> stop = [] { return false; };
};

/// Throws InputError where the plan names an engine or a device that does not exist, RunError where there is no OpenCL.
void check_plan(const Plan& plan);
/// Runs the plan. Throws InputError (no such engine or device), RunError (no OpenCL; poses that do not touch what they
/// should), Interrupted. What a device cannot hold is in Findings::skipped.
Findings run_bench(const Plan& plan, const BenchControl& control);

/// Depths of the approaches at a voxmap and a shell, as text to put into poses.cpp.
std::string find_depths(int voxmap, int shell);

}  // namespace reamsim::bench
