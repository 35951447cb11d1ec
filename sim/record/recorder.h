// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/csv.h"
#include "sim/base/file.h"
#include "sim/record/force_log.h"
#include "sim/record/results.h"
#include "sim/record/run_totals.h"

namespace reamsim {

inline constexpr const char* kForceBasisName = "force_basis.npy";

/// Writes force_basis.npy, an array of BasisRow (docs/columns.md).
class ForceBasisWriter {
 public:
  /// `bytes`: continues a file of which sync() returned so many; 0: begins a new one. Throws InputError where it is
  /// shorter, RunError.
  explicit ForceBasisWriter(const std::string& path, std::uintmax_t bytes = 0);

  void rows(const std::vector<BasisRow>& rows);
  /// Waits until all rows are on the disk. Returns the length of the file. Throws RunError.
  std::uintmax_t sync();
  /// Throws RunError when something could not be written.
  void close();

 private:
  void write_header();
  void check() const {
    if (!file_) fail_to_write(path_);
  }

  std::string path_;
  std::fstream file_;
  std::uintmax_t count_ = 0;  ///< rows
};

/// Reads a force basis, in ascending frames. Throws InputError: no such file, or damaged.
std::vector<BasisRow> read_force_basis(const std::string& path);

/// Lengths of forces.csv, timings.csv and force_basis.npy after a frame, bytes; 0 before the first one.
struct LogLengths {
  std::uintmax_t forces_bytes = 0;
  std::uintmax_t timings_bytes = 0;
  std::uintmax_t basis_bytes = 0;  ///< force_basis.npy; 0: not written
};

/// Writes forces.csv, timings.csv, snapshots/ and, where asked for, force_basis.npy frame by frame.
class Recorder final : public FrameSink {
 public:
  /// Opens the files in `dir`, with the columns of `feedback`. Where they were as long as `logs` says after `frame`,
  /// continues them, and adds up the rows again. Throws InputError where these are damaged, RunError.
  Recorder(const std::string& dir, double voxel_mm, bool force_basis = false, PoseFeedback feedback = {},
           const LogLengths& logs = {}, std::int64_t frame = 0, RemovedFrames removed = {});

  void frame(const FrameResult& result, const FrameTimes& times) override;
  void basis(const std::vector<BasisRow>& rows) override {
    if (basis_) basis_->rows(rows);
  }
  void snapshot(std::int64_t frame, FillBricks& fill) override;
  void removed(const RemovedFrames& voxels) override { removed_.insert(removed_.end(), voxels.begin(), voxels.end()); }
  /// Waits until all results so far are on the disk. Throws RunError.
  LogLengths sync();
  /// Flushes the logs; RunError when the disk is full.
  void close();

  [[nodiscard]] const RunTotals& totals() const { return totals_; }
  [[nodiscard]] const RemovedFrames& removed_frames() const { return removed_; }

 private:
  std::string dir_;
  CsvWriter forces_;
  CsvWriter timings_;
  std::optional<ForceBasisWriter> basis_;
  RunTotals totals_;
  RemovedFrames removed_;
  std::vector<std::string> unsynced_;  ///< snapshots that may not be on the disk
};

/// Writes the bricks that changed since the last snapshot to DIR/snapshots/NNNNNN.vdb: one FloatGrid `fill` (0…1) whose
/// leaves are those bricks, in voxel index space. The first snapshot (frame 0) holds every brick that is not whole.
/// Throws RunError when the file cannot be written.
void write_snapshot(const std::string& dir, std::int64_t frame, FillBricks& fill);

/// DIR/snapshots/tool.stl, or tool_N.stl of a later pass; the first one is 1.
std::string tool_path(const std::string& dir, int pass);

/// DIR/snapshots/NNNNNN.vdb
std::string snapshot_path(const std::string& dir, std::int64_t frame);

std::vector<std::int64_t> snapshot_frames(const std::string& dir);

/// Sets the bricks of one snapshot in `fill`. Throws InputError when the file is missing, truncated, damaged (the
/// checksum is verified first) or of another bone.
void apply_snapshot(const std::string& dir, std::int64_t frame, FillBricks& fill);

}  // namespace reamsim
