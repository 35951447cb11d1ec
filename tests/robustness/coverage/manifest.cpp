// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/output_folder.h"

#include "input_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace reamsim;
  return test::read_input(data, size, kManifestName, [](const std::string&) {
    if (const auto manifest = read_manifest(test::input_folder())) write_manifest(test::input_folder(), *manifest);
  });
}
