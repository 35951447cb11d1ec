// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "input_file.h"
#include "render/plots/plots.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace reamsim;
  return test::read_input(data, size, "summary.json", [](const std::string&) {
    const std::string& dir = test::input_folder();
    compare_summaries({{dir, "a"}, {dir, "b"}});
  });
}
