// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdlib>
#include <string>

namespace reamsim::test {

/// A file of the public CT and meshes, in the folder that REAMSIM_DATA names. Tests that need it are skipped where it
/// does not exist.
inline std::string data_file(const std::string& name) {
  const char* const folder = std::getenv("REAMSIM_DATA");
  return std::string(folder != nullptr ? folder : "") + "/" + name;
}

}  // namespace reamsim::test
