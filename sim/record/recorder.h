#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "sim/bone/bone_vdb.h"
#include "sim/record/csv_log.h"
#include "sim/record/results.h"
#include "sim/record/run_totals.h"

namespace reamsim {

/// Seconds that the stages of a frame took: broad phase on the host, detect and cut on the device.
struct FrameTimes {
  double broad_phase_s = 0;
  double detect_s = 0;
  double cut_s = 0;
};

/// Writes what a run gives into its folder while it goes: forces.csv, timings.csv, snapshots/.
class Recorder {
 public:
  /// Opens the files in `dir`; `voxel_mm` is the bone's. Throws RunError when they cannot be written.
  Recorder(const std::string& dir, double voxel_mm);

  void frame(const FrameResult& result, const FrameTimes& times);
  /// Bricks that changed since the last snapshot.
  void snapshot(std::int64_t frame, FillBricks& fill);
  void removed(const RemovedFrames& voxels);
  /// Flushes the logs; RunError when the disk is full.
  void close();

  [[nodiscard]] const RunTotals& totals() const { return totals_; }
  [[nodiscard]] const RemovedFrames& removed_frames() const { return removed_; }

 private:
  std::string dir_;
  CsvLog forces_;
  CsvLog timings_;
  RunTotals totals_;
  RemovedFrames removed_;
};

}  // namespace reamsim
