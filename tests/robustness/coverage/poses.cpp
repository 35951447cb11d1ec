// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "input_file.h"
#include "sim/tool/motion.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace reamsim;
  return test::read_input(data, size, "poses.csv", [](const std::string& path) {
    MotionSettings motion;
    motion.csv = CsvMotionSettings{.path = path, .spin_rpm = 250};
    Diagnostics report;
    const Motion built = build_motion(motion, std::nullopt, report);
    for (std::size_t k = 0; k < built.poses.size(); k += 1 + built.poses.size() / 100) built.poses[k];
  });
}
