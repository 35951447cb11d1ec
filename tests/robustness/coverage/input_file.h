// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "sim/base/error.h"

namespace reamsim::test {

/// A folder of this process, in which each input becomes a file.
inline const std::string& input_folder() {
  static const auto* folder = new std::string([] {  // used until the end of the process
    std::string pattern = (std::filesystem::temp_directory_path() / "reamsim-fuzz-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) std::abort();
    std::atexit([] {
      std::error_code ignored;
      std::filesystem::remove_all(input_folder(), ignored);
    });
    return pattern;
  }());
  return *folder;
}

/// Writes an input to the file `name`, and reads that. InputError is what a damaged file may throw; every other
/// exception ends the process, as crashes do.
template <class Read>
int read_input(const std::uint8_t* data, std::size_t size, const std::string& name, const Read& read) {
  const std::string path = input_folder() + "/" + name;
  std::ofstream(path, std::ios::binary | std::ios::trunc)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    read(path);
  } catch (const InputError& error) {
    if (std::string(error.what()).find(name) == std::string::npos) std::abort();  // names no file
  }
  return 0;
}

}  // namespace reamsim::test
