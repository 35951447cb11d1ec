#pragma once

#include <string>
#include <vector>

namespace reamsim::ct {

/// Reads DICOM files, header and pixels, in a child process, because GDCM as it is packaged asserts on damaged bytes
/// and takes the whole program with it. Throws InputError naming the file on which the child died; whatever else is
/// wrong with a file is left to the reader proper. Costs a second reading.
void check_dicom_in_child(const std::vector<std::string>& files, const std::string& key);

/// For each file whether reading its header leaves a child process alive.
std::vector<bool> dicom_headers_readable(const std::vector<std::string>& files);

}  // namespace reamsim::ct
