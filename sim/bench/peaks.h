// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/bench/findings.h"
#include "sim/device/opencl.h"

namespace reamsim::bench {

/// Operations of exact erosion for a voxel that loses bone in a frame of a window, a fused multiply-add as two: 36 for
/// its loss (rs_window_outside() with two pieces and rs_clip_loss()) and 32 for force, torque and energies
/// (kernels/cut_window.h).
inline constexpr double kExactOperations = 68;
/// Memory that it needs, bytes: fill read and written, and grade read, once in a window of 64 frames.
inline constexpr double kExactBytes = 5.0 / 64;

/// Measures the device: fused multiply-adds in registers, and a copy of 256 MB. The best of some repetitions.
MachinePeaks measure_peaks(const cl::DeviceInfo& info);

}  // namespace reamsim::bench
