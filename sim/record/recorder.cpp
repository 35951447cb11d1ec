// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/recorder.h"

#include <fmt/core.h>
#include <openvdb/openvdb.h>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <utility>

#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/bone/vdb/grids.h"

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

/// Sets every voxel of a brick, whole ones included, so that a leaf holds the complete brick.
void put_brick(openvdb::FloatGrid& grid, const Vec3i& brick_coord, const FillBricks& fill) {
  const FillBricks::Brick* brick = fill.brick(brick_coord);
  auto* leaf = grid.tree().touchLeaf(openvdb::Coord(8 * brick_coord.x(), 8 * brick_coord.y(), 8 * brick_coord.z()));
  for (int offset = 0; offset < FillBricks::kVoxels; ++offset) {
    const Vec3i voxel = BrickLattice::voxel_at(brick_coord, offset);
    const std::uint16_t units = brick == nullptr ? FillBricks::kWhole : (*brick)[static_cast<std::size_t>(offset)];
    leaf->setValueOn({voxel.x(), voxel.y(), voxel.z()}, static_cast<float>(units) / FillBricks::kWhole);
  }
}

}  // namespace

ForceBasisWriter::ForceBasisWriter(const std::string& path, std::uintmax_t bytes) : path_(path) {
  auto mode = std::ios::in | std::ios::out | std::ios::binary;
  if (bytes > 0) {
    cut_to_checkpoint(path, bytes, kHeaderBytes);
    count_ = (bytes - kHeaderBytes) / sizeof(BasisRow);
  } else {
    mode |= std::ios::trunc;
  }
  file_.open(path, mode);
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

Recorder::Recorder(const std::string& dir, double voxel_mm, bool force_basis, PoseFeedback feedback,
                   const LogLengths& logs, std::int64_t frame, RemovedFrames removed)
    : dir_(dir),
      forces_(dir + "/forces.csv", force_columns(feedback), logs.forces_bytes),
      timings_(dir + "/timings.csv", kTimingColumns, logs.timings_bytes),
      totals_(voxel_mm),
      removed_(std::move(removed)) {
  if (force_basis) basis_.emplace(dir + "/" + kForceBasisName, logs.basis_bytes);
  if (logs.forces_bytes == 0) return;
  for (const std::int64_t later : snapshot_frames(dir_)) {
    std::error_code ignored;
    if (later > frame) std::filesystem::remove(snapshot_path(dir_, later), ignored);
  }
  for_each_result(dir_ + "/forces.csv", feedback, [&](const FrameResult& result) { totals_.add(result); });
  const std::vector<std::string_view> columns = csv_cells(kTimingColumns);
  std::vector<double> row;
  for (CsvReader log(dir_ + "/timings.csv", columns, "the log of a run"); log.next(row);) {
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

std::string tool_path(const std::string& dir, int pass) {
  return dir + "/snapshots/tool" + (pass == 1 ? "" : "_" + std::to_string(pass)) + ".stl";
}

std::string snapshot_path(const std::string& dir, std::int64_t frame) {
  return fmt::format("{}/snapshots/{:06}.vdb", dir, frame);
}

void write_snapshot(const std::string& dir, std::int64_t frame, FillBricks& fill) {
  const std::string path = snapshot_path(dir, frame);
  openvdb::initialize();
  auto grid = make_float_grid(1.0F);
  grid->setName("fill");
  for (const Vec3i& brick : fill.take_changed()) put_brick(*grid, brick, fill);
  std::error_code ignored;  // writing reports it
  std::filesystem::create_directories(std::filesystem::path(path).parent_path(), ignored);
  write_vdb_file(path, {[&grid] { return grid; }}, {});
}

std::vector<std::int64_t> snapshot_frames(const std::string& dir) {
  std::vector<std::int64_t> frames;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(dir + "/snapshots", error)) {
    const std::string stem = entry.path().stem().string();
    const bool number = is_whole_number(stem) && stem.size() < 19;
    if (entry.path().extension() == ".vdb" && number) frames.push_back(std::stoll(stem));
  }
  std::sort(frames.begin(), frames.end());
  return frames;
}

void apply_snapshot(const std::string& dir, std::int64_t frame, FillBricks& fill) {
  const std::string path = snapshot_path(dir, frame);
  const openvdb::FloatGrid::Ptr grid = read_vdb_grid(path, "fill", VdbOrigin::kReamsim);
  for (auto value = grid->cbeginValueOn(); value; ++value) {
    const openvdb::Coord c = value.getCoord();
    const Vec3i voxel(c.x(), c.y(), c.z());
    if (!fill.lattice().contains(BrickLattice::brick_of(voxel)))
      refuse_file(path, "holds a brick outside the bone's lattice", "run the scenario again");
    const float units = std::clamp(value.getValue(), 0.0F, 1.0F) * FillBricks::kWhole;
    fill.set(voxel, static_cast<std::uint16_t>(std::lround(units)));
  }
}

}  // namespace reamsim
