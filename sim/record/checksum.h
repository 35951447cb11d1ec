#pragma once

#include <string>

namespace reamsim {

/// SHA-256 of a file, in hex; of a folder (DICOM, with its subfolders): of the relative paths and sums of its files in
/// order of path.
/// Throws InputError when something cannot be read.
std::string sha256_of(const std::string& path);

}  // namespace reamsim
