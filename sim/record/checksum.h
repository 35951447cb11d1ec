#pragma once

#include <string>

namespace reamsim {

/// SHA-256 of a file, in hex; of a folder (a DICOM series): of the names and sums of its files in order of name.
/// Throws InputError when something cannot be read.
std::string sha256_of(const std::string& path);

}  // namespace reamsim
