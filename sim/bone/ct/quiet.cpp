#include "sim/bone/ct/quiet.h"

#include <nifti1_io.h>

namespace reamsim::ct {

QuietLibraries::QuietLibraries()
    : cerr_(std::cerr.rdbuf(swallowed_.rdbuf())), cout_(std::cout.rdbuf(swallowed_.rdbuf())) {
  nifti_set_debug_level(0);
}

QuietLibraries::~QuietLibraries() {
  std::cout.rdbuf(cout_);
  std::cerr.rdbuf(cerr_);
}

}  // namespace reamsim::ct
