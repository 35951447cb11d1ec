#pragma once

#include <string>

namespace reamsim {

/// What --version prints: program, commit, build, libraries, OpenCL devices of this machine, licence.
std::string version_text();

}  // namespace reamsim
