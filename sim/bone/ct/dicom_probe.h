#pragma once

#include <string>
#include <vector>

namespace reamsim::ct {

/// Reads DICOM files, header and pixels, in a child process, because GDCM aborts the program on some damaged files.
/// Throws InputError with the file that crashed the child process; other errors are left to the reader.
void check_dicom_in_child(const std::vector<std::string>& files, const std::string& key);

/// For each file, whether a child process reads its header without a crash.
std::vector<bool> dicom_headers_readable(const std::vector<std::string>& files);

}  // namespace reamsim::ct
