// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/force_log.h"

#include "input_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace reamsim;
  return test::read_input(data, size, "forces.csv", [](const std::string& path) {
    read_force_log(path, {.mean_travel_mm = 0.5, .most_rows = 16});
  });
}
