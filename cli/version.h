// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

namespace reamsim {

/// What --version prints: program, commit, build, libraries, OpenCL devices of this machine, licence.
std::string version_text();

}  // namespace reamsim
