// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/scenario/parse.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {

/// A valid scenario, short enough to count its lines. The tool's mesh is a file that the fixture makes.
inline const std::string kValid =
    "version: 2\n"                                                   // 1
    "bone:\n"                                                        // 2
    "  source: phantom\n"                                            // 3
    "  voxel_mm: 0.5\n"                                              // 4
    "  phantom:\n"                                                   // 5
    "    shape: half_space\n"                                        // 6
    "    size_mm: [10, 10, 6]\n"                                     // 7
    "tool:\n"                                                        // 8
    "  mesh: tool.stl\n"                                             // 9
    "motion:\n"                                                      // 10
    "  keyframes:\n"                                                 // 11
    "    - {time_s: 0, position_mm: [0, 0, 1], axis: [0, 0, 1]}\n"   // 12
    "    - {time_s: 1, position_mm: [0, 0, -1], axis: [0, 0, 1]}\n"  // 13
    "render:\n"                                                      // 14
    "  enabled: false\n";                                            // 15

/// A fresh folder with a tool in it, and what the parser says of scenarios there.
class ScenarioTest : public ::testing::Test {
 protected:
  ScenarioTest() { write("tool.stl", "solid\nendsolid\n"); }

  std::string path(const std::string& name) const { return dir_ + "/" + name; }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(path(name), std::ios::binary) << text;
  }

  Scenario parse(const std::string& yaml, const std::vector<std::string>& overrides = {}) const {
    write("s.yaml", yaml);
    return parse_scenario(path("s.yaml"), overrides);
  }

  /// The parser's complaint, without the temp folder's name; "" when there is none.
  std::string complaint(const std::string& yaml, const std::vector<std::string>& overrides = {}) const {
    write("s.yaml", yaml);
    return complaint_of_file("s.yaml", overrides);
  }
  std::string complaint_of_file(const std::string& name, const std::vector<std::string>& overrides = {}) const {
    try {
      parse_scenario(path(name), overrides);
    } catch (const InputError& error) {
      return without_dir(error.what());
    }
    return "";
  }
  std::string without_dir(std::string text) const {
    for (std::size_t at = text.find(dir_ + "/"); at != std::string::npos; at = text.find(dir_ + "/")) {
      text.erase(at, dir_.size() + 1);
    }
    return text;
  }

  TempDir temp_;
  const std::string dir_ = temp_.path();
};

/// `text` with one passage replaced; the passage must be there.
inline std::string with(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("no such passage: " + from);
  return text.replace(at, from.size(), to);
}

}  // namespace reamsim::test
