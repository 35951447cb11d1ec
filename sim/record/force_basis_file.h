// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "sim/record/results.h"

namespace reamsim {

/// The file of a run's force basis.
inline constexpr const char* kForceBasisName = "force_basis.npy";

/// Writes force_basis.npy, an array of BasisRow (docs/columns.md).
class ForceBasisWriter {
 public:
  /// Throws RunError when the file cannot be created.
  explicit ForceBasisWriter(const std::string& path);
  /// Continues a file that sync() said has `bytes` bytes; what follows them is removed. Throws InputError where it is
  /// shorter, RunError where it cannot be written.
  ForceBasisWriter(const std::string& path, std::uintmax_t bytes);

  void rows(const std::vector<BasisRow>& rows);
  /// Waits until all rows are on the disk. Returns the length of the file. Throws RunError.
  std::uintmax_t sync();
  /// Throws RunError when something could not be written.
  void close();

 private:
  void write_header();
  void check() const;

  std::string path_;
  std::fstream file_;
  std::uintmax_t count_ = 0;  ///< rows
};

/// Reads a force basis, in ascending frames. Throws InputError: no such file, or damaged.
std::vector<BasisRow> read_force_basis(const std::string& path);

}  // namespace reamsim
