// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <openvdb/openvdb.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

namespace reamsim {

// Files of OpenVDB grids whose damage is detected. OpenVDB does not validate what it reads, so a damaged file may crash
// it. Files of reamsim therefore end with a checksum after the data of OpenVDB, which their metadata announce. All
// files are read by child processes.

/// Makes a grid that is about to be written.
using GridMaker = std::function<openvdb::GridBase::Ptr()>;

/// Writes the grids and the metadata of the file, which appears when it is complete. Makes a grid while the one before
/// is written. The bytes depend only on the contents. Throws RunError when the file cannot be written, and what a maker
/// throws.
void write_vdb_file(const std::string& path, const std::vector<GridMaker>& grids, const openvdb::MetaMap& metadata);

/// Whether the beginning of a file is that of write_vdb_file(). Does not check the rest.
bool is_vdb_of_reamsim(const std::string& path);

/// Which programs may have written a file.
enum class VdbOrigin { kAnyProgram, kReamsim };

/// A VDB file opened for reading. Throws InputError: no such file, a folder, not a VDB, truncated, damaged; with
/// VdbOrigin::kReamsim also without checksum.
class VdbFile {
 public:
  explicit VdbFile(const std::string& path, VdbOrigin origin = VdbOrigin::kAnyProgram);

  [[nodiscard]] bool has(const std::string& grid) const { return std::ranges::count(names_, grid) > 0; }
  /// Names of all grids, for messages.
  [[nodiscard]] std::string grid_names() const;
  /// Throws InputError when the grid is damaged or not a FloatGrid.
  [[nodiscard]] openvdb::FloatGrid::Ptr read(const std::string& grid) const;

 private:
  std::string path_;
  std::vector<std::string> names_;
};

}  // namespace reamsim
