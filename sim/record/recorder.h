#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "sim/base/csv.h"
#include "sim/record/results.h"
#include "sim/record/run_totals.h"

namespace reamsim {

/// Writes the results of a run into its folder frame by frame: forces.csv, timings.csv, snapshots/.
class Recorder final : public FrameSink {
 public:
  /// Opens the files in `dir`. `voxel_mm`: of the bone. Throws RunError when they cannot be written.
  Recorder(const std::string& dir, double voxel_mm);

  void frame(const FrameResult& result, const FrameTimes& times) override;
  /// Bricks that changed since the last snapshot.
  void snapshot(std::int64_t frame, FillBricks& fill) override;
  void removed(const RemovedFrames& voxels) override;
  /// Flushes the logs; RunError when the disk is full.
  void close();

  [[nodiscard]] const RunTotals& totals() const { return totals_; }
  [[nodiscard]] const RemovedFrames& removed_frames() const { return removed_; }

 private:
  std::string dir_;
  CsvWriter forces_;
  CsvWriter timings_;
  RunTotals totals_;
  RemovedFrames removed_;
};

}  // namespace reamsim
