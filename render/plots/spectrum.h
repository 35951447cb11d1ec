#pragma once

#include <vector>

#include "sim/record/force_log.h"

namespace reamsim {

/// One-sided amplitude spectrum of the spin torque while the tool cuts.
struct TorqueSpectrum {
  struct Line {
    double frequency_hz = 0;
    double torque_nmm = 0;  ///< amplitude of the sine that would give this line
  };
  std::vector<Line> lines;
  std::vector<Line> peaks;  ///< the highest at multiples of the spin, ascending in frequency
  double spin_hz = 0;       ///< turns per second while cutting
};

/// The longest stretch of frames with torque, less its mean over one turn (which takes the feed's slow rise away and
/// leaves every multiple of the spin alone), in windows of Hann that overlap by half (Welch 1967,
/// doi:10.1109/TAU.1967.1161901), zeros appended for smooth lines. Empty when fewer than three turns are left, or the
/// tool does not spin.
TorqueSpectrum torque_spectrum(const ForceLog& log);

}  // namespace reamsim
