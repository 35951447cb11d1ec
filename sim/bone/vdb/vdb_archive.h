#pragma once

#include <openvdb/openvdb.h>

#include <string>

namespace reamsim {

// Files of OpenVDB grids that cannot be damaged unseen. OpenVDB trusts every byte that it reads, so a damaged file may
// crash it; ours therefore end with a checksum behind what OpenVDB reads, and say so in their metadata. Files of other
// programs are read by a child process first.

/// Writes the grids and the file's metadata to PATH.tmp and puts it in PATH's place when it is complete. The bytes of
/// the grids depend on nothing but their contents. Throws RunError when the file cannot be written.
void write_vdb_file(const std::string& path, const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& metadata);

/// Whether a file begins like those that write_vdb_file() writes, complete or not. Reads no further.
bool is_vdb_of_reamsim(const std::string& path);

/// Who may have written a file that is to be read.
enum class VdbOrigin { kAnyProgram, kReamsim };

/// A VDB file opened for reading. Throws InputError: no such file, a folder, not a VDB, truncated, damaged; with
/// VdbOrigin::kReamsim also without our checksum, so that OpenVDB never meets bytes that nobody vouches for.
class VdbFile {
 public:
  explicit VdbFile(const std::string& path, VdbOrigin origin = VdbOrigin::kAnyProgram);

  [[nodiscard]] bool has(const std::string& grid) const { return file_.hasGrid(grid); }
  /// Names of all grids, for messages.
  [[nodiscard]] std::string grid_names() const;
  /// Throws InputError when the grid is damaged or no FloatGrid.
  openvdb::FloatGrid::Ptr read(const std::string& grid);

 private:
  std::string path_;
  openvdb::io::File file_;
};

}  // namespace reamsim
