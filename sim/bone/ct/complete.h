#pragma once

#include <string>

namespace reamsim::ct {

/// Whether the voxels that a NIfTI header claims are all in its file (or its .img), packed or not. ITK itself takes
/// what is missing as whatever lay in memory.
bool nifti_is_complete(const std::string& path);

/// Whether MetaIO or GDCM printed that voxels are missing. They print it and go on; nothing else tells.
bool says_incomplete(const std::string& library_output);

}  // namespace reamsim::ct
