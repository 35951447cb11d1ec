// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "input_file.h"
#include "sim/scenario/parse.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace reamsim;
  return test::read_input(data, size, "scenario.yaml", [](const std::string& path) {
    parse_result_settings(path);
    to_yaml(parse_scenario(path, {}));
  });
}
