// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/csv.h"
#include "sim/record/force_basis_file.h"
#include "sim/record/force_log.h"
#include "sim/record/results.h"
#include "sim/record/run_totals.h"

namespace reamsim {

/// Lengths of forces.csv, timings.csv and force_basis.npy after a frame, bytes.
struct LogLengths {
  std::uintmax_t forces_bytes = 0;
  std::uintmax_t timings_bytes = 0;
  std::uintmax_t basis_bytes = 0;  ///< force_basis.npy; 0: not written
};

/// Writes the results of a run into its folder frame by frame: forces.csv, timings.csv, snapshots/, and
/// force_basis.npy where asked for.
class Recorder final : public FrameSink {
 public:
  /// Opens the files in `dir`. `voxel_mm`: of the bone. Throws RunError when they cannot be written.
  /// `feedback`: rows have its columns.
  Recorder(const std::string& dir, double voxel_mm, bool force_basis = false, PoseFeedback feedback = {});
  /// Continues the files after `frame`: removes what was written later, and adds up the rows again. Throws InputError
  /// where they are damaged, RunError where they cannot be written.
  Recorder(const std::string& dir, double voxel_mm, std::int64_t frame, const LogLengths& logs, RemovedFrames removed,
           PoseFeedback feedback = {});

  void frame(const FrameResult& result, const FrameTimes& times) override;
  void basis(const std::vector<BasisRow>& rows) override;
  /// Bricks that changed since the last snapshot.
  void snapshot(std::int64_t frame, FillBricks& fill) override;
  void removed(const RemovedFrames& voxels) override;
  /// Waits until all results so far are on the disk. Throws RunError.
  LogLengths sync();
  /// Flushes the logs; RunError when the disk is full.
  void close();

  [[nodiscard]] const RunTotals& totals() const { return totals_; }
  [[nodiscard]] const RemovedFrames& removed_frames() const { return removed_; }

 private:
  void add_rows_again();

  std::string dir_;
  std::string columns_;  ///< of forces.csv
  CsvWriter forces_;
  CsvWriter timings_;
  std::optional<ForceBasisWriter> basis_;
  RunTotals totals_;
  RemovedFrames removed_;
  std::vector<std::string> unsynced_;  ///< snapshots that may not be on the disk
};

}  // namespace reamsim
