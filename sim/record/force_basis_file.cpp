// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/force_basis_file.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <string_view>

#include "sim/base/error.h"
#include "sim/base/file.h"

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

[[noreturn]] void fail_as_damaged(const std::string& path, const std::string& found) {
  throw InputError({path, 0, 0}, "", found, "expected the force basis of a run with output.force_basis: true");
}

bool is_plausible(const BasisRow& row, std::int32_t frame_before) {
  const float* const values = row.p_mm2;
  for (std::size_t i = 0; i < kBasisRowValues; ++i)
    if (!std::isfinite(values[i])) return false;
  return row.frame >= frame_before && row.grade >= 0 && row.grade <= 255;
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

void ForceBasisWriter::check() const {
  if (!file_) fail_to_write(path_);
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

}  // namespace reamsim
