#pragma once

#include <string>
#include <vector>

#include "sim/bench/suite.h"
#include "sim/engine/common/engine.h"
#include "sim/motion/motion.h"

namespace reamsim::bench {

/// A run of `erosion: exact`, to be timed. The bone is the caller's.
struct ExactRun {
  const FilledVoxmap* bone = nullptr;
  const Tool* tool = nullptr;
  Motion motion;  ///< see straight_motion(); the first pose removes what is inside the tool
  std::string device = "auto";
  int cores = 0;  ///< compute units of the device; 0: all
};

/// Frames of an ExactRun, timed over its whole windows of 64 frames but the first. A whole frame is what `reamsim run`
/// does: substeps, broad phase, windows, kernels, sums read, rows of forces.csv and timings.csv written.
struct WholeFrames {
  std::vector<double> ms;         ///< per whole frame, by window
  std::vector<double> kernel_ms;  ///< of it: kernels, by the clock of the device
  double voxels = 0;              ///< that lose bone in a frame, mean
  double removed_mm3 = 0;         ///< in the whole run
  StructureBytes bytes;
};

/// Runs the main loop (sim/run/simulation.h) with its files in a temporary folder. Throws Interrupted, RunError,
/// InputError.
WholeFrames time_whole_frames(const ExactRun& run, const BenchControl& control);

/// A straight motion at 1 kHz along −z of T, of `windows` windows of 64 frames, which end at `last`, and one frame
/// more: the last frame of a run includes that its fill is read back.
Motion straight_motion(const ToolPose& last, double feed_mm_s, int windows);

}  // namespace reamsim::bench
