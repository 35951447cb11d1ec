// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <openvdb/openvdb.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace reamsim {

// Files of OpenVDB grids, read by child processes. OpenVDB does not validate what it reads, so a damaged file may crash
// it: files of reamsim end with a checksum after its data, which their metadata announce.

/// Makes a grid that is about to be written.
using GridMaker = std::function<openvdb::GridBase::Ptr()>;

/// Writes the grids and the metadata of the file, which appears when it is complete. Makes a grid while the one before
/// is written. The bytes depend only on the contents. Throws RunError, and what a maker throws.
void write_vdb_file(const std::string& path, const std::vector<GridMaker>& grids, const openvdb::MetaMap& metadata);

/// Whether the beginning of a file is that of write_vdb_file(). Does not check the rest.
bool is_vdb_of_reamsim(const std::string& path);

/// Which programs may have written a file.
enum class VdbOrigin { kAnyProgram, kReamsim };

/// What was read of a VDB file.
struct VdbGrids {
  std::string names;  ///< of all grids, for messages
  std::map<std::string, openvdb::FloatGrid::Ptr> grids;
};

/// Reads those of the `wanted` grids that a file has; none where the first, of which the others are part, is missing.
/// Throws InputError: no such file, a folder, not a VDB, truncated, damaged, a grid that is not a FloatGrid; with
/// VdbOrigin::kReamsim also without checksum.
VdbGrids read_vdb_file(const std::string& path, const std::vector<std::string>& wanted,
                       VdbOrigin origin = VdbOrigin::kAnyProgram);

/// Reads one grid. Throws as read_vdb_file(), and where it is missing.
openvdb::FloatGrid::Ptr read_vdb_grid(const std::string& path, const std::string& name,
                                      VdbOrigin origin = VdbOrigin::kAnyProgram);

}  // namespace reamsim
