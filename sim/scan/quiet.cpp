// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/quiet.h"

#include <fcntl.h>
#include <nifti1_io.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>

namespace reamsim::ct {

QuietLibraries::QuietLibraries()
    : cerr_(std::cerr.rdbuf(captured_.rdbuf())), cout_(std::cout.rdbuf(captured_.rdbuf())) {
  nifti_set_debug_level(0);
  // The NIfTI library prints some errors to C's stderr at any debug level.
  std::fflush(stderr);
  stderr_ = dup(STDERR_FILENO);
  const int null_device = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (stderr_ >= 0 && null_device >= 0) dup2(null_device, STDERR_FILENO);
  if (null_device >= 0) close(null_device);
}

QuietLibraries::~QuietLibraries() {
  std::fflush(stderr);
  if (stderr_ >= 0) {
    dup2(stderr_, STDERR_FILENO);
    close(stderr_);
  }
  std::cout.rdbuf(cout_);
  std::cerr.rdbuf(cerr_);
}

bool QuietLibraries::reports_missing_voxels() const {
  constexpr std::array<const char*, 3> kMessages{"data not read completely", "Uncompress failed",
                                                 "Incomplete Pixel Data"};
  const std::string output = captured_.str();
  return std::ranges::any_of(kMessages, [&](const char* text) { return output.find(text) != std::string::npos; });
}

}  // namespace reamsim::ct
