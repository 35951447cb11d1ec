// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <sstream>

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {

/// 4 runs of 40 frames.
inline const std::string kStudy =
    "version: 1\n"
    "base: s.yaml\n"
    "vary:\n"
    "  - motion.plunge.depth_mm: [0.5, 1]\n"
    "sample: {n: 2, seed: 3, of: {cutting.specific_energy_j_mm3: {lognormal: [0.15, 0.3]}}}\n"
    "keep: [summary, forces]\n";

/// A study of kSmall in a folder of its own.
class Sweep : public CliTest {
 protected:
  Sweep() {
    write("s.yaml", with(kSmall, "    dwell_s: 0\n", "    dwell_s: 0\n    axis: [0, 0, -1]\n"));
    write("study.yaml", kStudy);
  }

  ProgramResult sweep(std::vector<std::string> arguments, const std::function<bool()>& when = {},
                      int signal = SIGTERM) const {
    arguments.insert(arguments.begin(), "sweep");
    ProgramCall call{.arguments = std::move(arguments), .environment = {}, .folder = "", .interrupt_when = when};
    call.interrupt_signal = signal;
    return reamsim(call);
  }
  /// Finished runs in a study's folder.
  [[nodiscard]] std::ptrdiff_t finished(const std::string& dir) const {
    if (!exists(dir + "/runs")) return 0;
    return std::ranges::count_if(
        std::filesystem::directory_iterator(path(dir + "/runs")),
        [](const std::filesystem::directory_entry& entry) { return !entry.path().has_extension(); });
  }
  /// Whether a run has begun and not ended.
  [[nodiscard]] bool is_running(const std::string& dir) const {
    return exists(dir + "/runs") && std::ranges::any_of(std::filesystem::directory_iterator(path(dir + "/runs")),
                                                        [](const std::filesystem::directory_entry& entry) {
                                                          return entry.path().extension() == ".partial";
                                                        });
  }
  [[nodiscard]] std::vector<std::string> lines(const std::string& file) const {
    std::istringstream text(read(file));
    std::vector<std::string> out;
    for (std::string line; std::getline(text, line);) out.push_back(line);
    return out;
  }
};

}  // namespace reamsim::test
