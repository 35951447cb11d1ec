// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/bench/suite.h"
#include "sim/engine/common/engine.h"
#include "sim/tool/motion.h"

namespace reamsim::bench {

/// Runs of `erosion: exact`, to be timed, each on the whole bone. Bone and tool are the caller's.
struct ExactRuns {
  const FilledVoxmap* bone = nullptr;
  const Tool* tool = nullptr;
  std::vector<Motion> motions;  ///< see straight_motion(); the first pose removes what is inside the tool
  std::string device = "auto";
  int cores = 0;  ///< compute units of the device; 0: all
};

/// Frames of ExactRuns, timed over the whole windows of 64 frames of each run but its first. A whole frame is what
/// `reamsim run` does: substeps, broad phase, windows, kernels, sums read, rows of forces.csv and timings.csv written.
struct WholeFrames {
  std::vector<double> ms;         ///< per whole frame, by window
  std::vector<double> kernel_ms;  ///< of it: kernels, by the clock of the device
  double voxels = 0;              ///< that lose bone in a frame, mean
  double removed_mm3 = 0;         ///< in the whole of the last run
  StructureBytes bytes;
};

/// Runs the main loop (sim/run/simulation.h) with its files in temporary folders. Throws Interrupted, RunError,
/// InputError.
WholeFrames time_whole_frames(const ExactRuns& runs, const BenchControl& control);

/// A straight motion at 1 kHz along −z of T, of `windows` windows of 64 frames, which end at `last`, and one frame
/// more: the last frame of a run includes that its fill is read back.
Motion straight_motion(const ToolPose& last, double feed_mm_s, int windows);

}  // namespace reamsim::bench
