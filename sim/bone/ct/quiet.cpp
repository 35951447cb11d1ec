#include "sim/bone/ct/quiet.h"

#include <fcntl.h>
#include <nifti1_io.h>
#include <unistd.h>

#include <cstdio>

namespace reamsim::ct {

QuietLibraries::QuietLibraries()
    : cerr_(std::cerr.rdbuf(swallowed_.rdbuf())), cout_(std::cout.rdbuf(swallowed_.rdbuf())) {
  nifti_set_debug_level(0);
  // The NIfTI library prints some errors by C's own means, whatever its debug level.
  std::fflush(stderr);
  stderr_ = dup(STDERR_FILENO);
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (stderr_ >= 0 && nowhere >= 0) dup2(nowhere, STDERR_FILENO);
  if (nowhere >= 0) close(nowhere);
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

}  // namespace reamsim::ct
