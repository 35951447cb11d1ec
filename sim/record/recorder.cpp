// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/recorder.h"

#include <utility>

#include "sim/base/file.h"
#include "sim/record/snapshot.h"

namespace reamsim {

namespace {

constexpr const char* kTimingColumns = "frame,broad_phase_ms,detect_ms,cut_ms";

}  // namespace

Recorder::Recorder(const std::string& dir, double voxel_mm, bool force_basis, PoseFeedback feedback)
    : dir_(dir),
      columns_(force_columns(feedback)),
      forces_(dir + "/forces.csv", columns_),
      timings_(dir + "/timings.csv", kTimingColumns),
      totals_(voxel_mm) {
  if (force_basis) basis_.emplace(dir + "/" + kForceBasisName);
}

Recorder::Recorder(const std::string& dir, double voxel_mm, std::int64_t frame, const LogLengths& logs,
                   RemovedFrames removed, PoseFeedback feedback)
    : dir_(dir),
      columns_(force_columns(feedback)),
      forces_(dir + "/forces.csv", columns_, logs.forces_bytes),
      timings_(dir + "/timings.csv", kTimingColumns, logs.timings_bytes),
      totals_(voxel_mm),
      removed_(std::move(removed)) {
  if (logs.basis_bytes > 0) basis_.emplace(dir + "/" + kForceBasisName, logs.basis_bytes);
  remove_snapshots_after(dir, frame);
  add_rows_again();
}

void Recorder::add_rows_again() {
  const std::vector<std::string_view> forces = csv_cells(columns_), timings = csv_cells(kTimingColumns);
  std::vector<double> row;
  for (CsvReader log(dir_ + "/forces.csv", forces, "the log of a run"); log.next(row);) {
    totals_.add(result_of(row, log.where()));
  }
  for (CsvReader log(dir_ + "/timings.csv", timings, "the log of a run"); log.next(row);) {
    totals_.broad_phase_s += row[1] / 1e3;
    totals_.detect_s += row[2] / 1e3;
    totals_.cut_s += row[3] / 1e3;
  }
}

void Recorder::frame(const FrameResult& r, const FrameTimes& times) {
  forces_.row(force_row(r));
  timings_.row({static_cast<double>(r.frame), 1e3 * times.broad_phase_s, 1e3 * times.detect_s, 1e3 * times.cut_s});
  totals_.add(r);
  totals_.broad_phase_s += times.broad_phase_s;
  totals_.detect_s += times.detect_s;
  totals_.cut_s += times.cut_s;
}

void Recorder::basis(const std::vector<BasisRow>& rows) {
  if (basis_) basis_->rows(rows);
}

void Recorder::snapshot(std::int64_t frame, FillBricks& fill) {
  write_snapshot(dir_, frame, fill);
  unsynced_.push_back(snapshot_path(dir_, frame));
}

void Recorder::removed(const RemovedFrames& voxels) {
  removed_.insert(removed_.end(), voxels.begin(), voxels.end());
}

LogLengths Recorder::sync() {
  for (const std::string& snapshot : std::exchange(unsynced_, {})) sync_to_disk(snapshot);
  sync_to_disk(dir_ + "/snapshots");
  return {.forces_bytes = forces_.sync(), .timings_bytes = timings_.sync(), .basis_bytes = basis_ ? basis_->sync() : 0};
}

void Recorder::close() {
  forces_.close();
  timings_.close();
  if (basis_) basis_->close();
}

}  // namespace reamsim
