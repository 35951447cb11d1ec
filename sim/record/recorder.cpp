// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/recorder.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <utility>

#include "sim/base/error.h"
#include "sim/record/snapshot.h"

namespace reamsim {

namespace {

// Numbers in the file are those of the memory, and the header says that they are little-endian.
static_assert(std::endian::native == std::endian::little);
static_assert(sizeof(BasisRow) == 76 && std::is_trivially_copyable_v<BasisRow>);

constexpr std::string_view kNpyMagic("\x93NUMPY\x01\x00", 8);

/// The format NPY 1.0 aligns the data to 64 bytes.
constexpr std::size_t kHeaderBytes = 512;

constexpr std::string_view kRowType =
    "[('frame', '<i4'), ('grade', '<i4'), ('density_g_cm3', '<f4'), ('p_mm2', '<f4', (3,)), ('p_torque_mm3', '<f4', "
    "(3,)), ('n_mm2', '<f4', (3,)), ('n_torque_mm3', '<f4', (3,)), ('p_work_mm3', '<f4'), ('n_work_mm3', '<f4'), "
    "('energy_mm3', '<f4'), ('floor_energy_mm3', '<f4')]";

/// The header of a file with `rows` rows: always as long, so that it can be replaced.
std::string header_of(std::uintmax_t rows) {
  std::string text =
      "{'descr': " + std::string(kRowType) + ", 'fortran_order': False, 'shape': (" + std::to_string(rows) + ",), }";
  text.resize(kHeaderBytes - kNpyMagic.size() - 2 - 1, ' ');
  text += '\n';
  const auto length = static_cast<std::uint16_t>(text.size());
  std::string out(kNpyMagic);
  out += static_cast<char>(length & 0xff);
  out += static_cast<char>(length >> 8);
  return out + text;
}

constexpr const char* kTimingColumns = "frame,broad_phase_ms,detect_ms,cut_ms";

[[noreturn]] void fail_as_damaged(const std::string& path, const std::string& found) {
  throw InputError({path, 0, 0}, "", found, "expected the force basis of a run with output.force_basis: true");
}

bool is_plausible(const BasisRow& row, std::int32_t frame_before) {
  const bool finite =
      std::all_of(row.p_mm2, row.p_mm2 + kBasisRowValues, [](float value) { return std::isfinite(value); });
  return finite && row.frame >= frame_before && row.grade >= 0 && row.grade <= 255;
}

}  // namespace

ForceBasisWriter::ForceBasisWriter(const std::string& path)
    : path_(path), file_(path, std::ios::in | std::ios::out | std::ios::binary | std::ios::trunc) {
  write_header();
}

ForceBasisWriter::ForceBasisWriter(const std::string& path, std::uintmax_t bytes) : path_(path) {
  std::error_code error;
  if (std::filesystem::file_size(path, error) < bytes || error || bytes < kHeaderBytes) {
    throw InputError({path, 0, 0}, "", "is shorter than when the checkpoint was written",
                     "start again with --overwrite");
  }
  std::filesystem::resize_file(path, bytes, error);
  if (error) fail_to_write(path);
  count_ = (bytes - kHeaderBytes) / sizeof(BasisRow);
  file_.open(path, std::ios::in | std::ios::out | std::ios::binary);
  write_header();
}

void ForceBasisWriter::rows(const std::vector<BasisRow>& rows) {
  file_.write(reinterpret_cast<const char*>(rows.data()), static_cast<std::streamsize>(rows.size() * sizeof(BasisRow)));
  check();
  count_ += rows.size();
}

void ForceBasisWriter::write_header() {
  file_.seekp(0);
  file_ << header_of(count_);
  file_.seekp(0, std::ios::end);
  file_.flush();
  check();
}

std::uintmax_t ForceBasisWriter::sync() {
  write_header();
  sync_to_disk(path_);
  return kHeaderBytes + count_ * sizeof(BasisRow);
}

void ForceBasisWriter::close() {
  write_header();
  file_.close();
  check();
}

std::vector<BasisRow> read_force_basis(const std::string& path) {
  const std::string text = read_file(path, "the force basis of a run with output.force_basis: true");
  if (text.size() < kHeaderBytes || (text.size() - kHeaderBytes) % sizeof(BasisRow) != 0)
    fail_as_damaged(path, "is damaged or truncated");
  const std::size_t count = (text.size() - kHeaderBytes) / sizeof(BasisRow);
  if (!text.starts_with(header_of(count))) fail_as_damaged(path, "is no force basis of this version, or is truncated");
  std::vector<BasisRow> out(count);
  if (count > 0) std::memcpy(out.data(), text.data() + kHeaderBytes, count * sizeof(BasisRow));
  std::int32_t frame = 0;
  for (const BasisRow& row : out) {
    if (!is_plausible(row, frame)) fail_as_damaged(path, "has damaged rows");
    frame = row.frame;
  }
  return out;
}

Recorder::Recorder(const std::string& dir, double voxel_mm, bool force_basis, PoseFeedback feedback)
    : dir_(dir),
      forces_(dir + "/forces.csv", force_columns(feedback)),
      timings_(dir + "/timings.csv", kTimingColumns),
      totals_(voxel_mm) {
  if (force_basis) basis_.emplace(dir + "/" + kForceBasisName);
}

Recorder::Recorder(const std::string& dir, double voxel_mm, std::int64_t frame, const LogLengths& logs,
                   RemovedFrames removed, PoseFeedback feedback)
    : dir_(dir),
      forces_(dir + "/forces.csv", force_columns(feedback), logs.forces_bytes),
      timings_(dir + "/timings.csv", kTimingColumns, logs.timings_bytes),
      totals_(voxel_mm),
      removed_(std::move(removed)) {
  if (logs.basis_bytes > 0) basis_.emplace(dir + "/" + kForceBasisName, logs.basis_bytes);
  remove_snapshots_after(dir, frame);
  for_each_result(dir + "/forces.csv", feedback, [&](const FrameResult& result) { totals_.add(result); });
  const std::vector<std::string_view> columns = csv_cells(kTimingColumns);
  std::vector<double> row;
  for (CsvReader log(dir + "/timings.csv", columns, "the log of a run"); log.next(row);) {
    totals_.times += {row[1] / 1e3, row[2] / 1e3, row[3] / 1e3};
  }
}

void Recorder::frame(const FrameResult& r, const FrameTimes& times) {
  forces_.row(force_row(r));
  timings_.row({static_cast<double>(r.frame), 1e3 * times.broad_phase_s, 1e3 * times.detect_s, 1e3 * times.cut_s});
  totals_.add(r);
  totals_.times += times;
}

void Recorder::snapshot(std::int64_t frame, FillBricks& fill) {
  write_snapshot(dir_, frame, fill);
  unsynced_.push_back(snapshot_path(dir_, frame));
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
