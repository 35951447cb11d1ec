#include "sim/bone/ct/quiet.h"

#include <itkObject.h>
#include <nifti1_io.h>

namespace reamsim::ct {

QuietLibraries::QuietLibraries()
    : cerr_(std::cerr.rdbuf(swallowed_.rdbuf())),
      cout_(std::cout.rdbuf(swallowed_.rdbuf())),
      itk_warned_(itk::Object::GetGlobalWarningDisplay()) {
  itk::Object::SetGlobalWarningDisplay(false);
  nifti_set_debug_level(0);
}

QuietLibraries::~QuietLibraries() {
  itk::Object::SetGlobalWarningDisplay(itk_warned_);
  std::cout.rdbuf(cout_);
  std::cerr.rdbuf(cerr_);
}

}  // namespace reamsim::ct
