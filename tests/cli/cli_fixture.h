// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/cli/subprocess.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {

/// Small enough to run in a fraction of a second: 40 frames.
inline const std::string kSmall =
    "version: 2\n"                // 1
    "bone:\n"                     // 2
    "  source: phantom\n"         // 3
    "  voxel_mm: 0.5\n"           // 4
    "  phantom:\n"                // 5
    "    shape: half_space\n"     // 6
    "    size_mm: [10, 10, 6]\n"  // 7
    "tool:\n"                     // 8
    "  mesh: " REAMSIM_ROOT
    "/assets/reamer_flat.stl\n"  // 9
    "motion:\n"                  // 10
    "  frame_rate_hz: 100\n"     // 11
    "  plunge:\n"                // 12
    "    approach_mm: 0.5\n"     // 13
    "    feed_mm_s: 5\n"         // 14
    "    depth_mm: 1\n"          // 15
    "    dwell_s: 0\n"           // 16
    "    retract_mm: 2\n"        // 17
    "    retract_mm_s: 20\n"     // 18
    "render:\n"                  // 19
    "  enabled: false\n"         // 20
    "engine:\n"                  // 21
    "  device: serial\n";        // 22

/// `text` with one passage replaced; the passage must be there.
inline std::string with(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("no such passage: " + from);
  return text.replace(at, from.size(), to);
}

/// kSmall with another bone section (its lines indented by two).
inline std::string with_bone(const std::string& lines) {
  return with(kSmall,
              "  source: phantom\n  voxel_mm: 0.5\n  phantom:\n    shape: half_space\n    size_mm: [10, 10, 6]\n",
              lines);
}

/// The number that follows `key`.
inline double number_after(const std::string& text, const std::string& key) {
  const std::size_t at = text.find(key);
  EXPECT_NE(at, std::string::npos) << key << " in\n" << text;
  return at == std::string::npos ? 0 : std::stod(text.substr(at + key.size()));
}

/// A fresh folder in which the built program is run.
class CliTest : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return dir_ + "/" + name; }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(path(name), std::ios::binary) << text;
  }
  std::string read(const std::string& name) const { return file_bytes(path(name)); }
  bool exists(const std::string& name) const { return std::filesystem::exists(path(name)); }

  /// Runs `reamsim` in the folder. `reamsim run` draws plots only with plots_, and makes meshes only with plots_ or
  /// meshes_: together they take two thirds of the time of a small run.
  ProgramResult reamsim(ProgramCall call) const {
    if (call.folder.empty()) call.folder = dir_;
    if (!plots_ && call.arguments.size() > 2 && call.arguments[0] == "run") {
      call.arguments.emplace_back("--set=output.plots=false");
      if (!meshes_) call.arguments.emplace_back("--set=output.meshes=false");
    }
    return run_program(REAMSIM_PROGRAM, call);
  }
  /// `reamsim run s.yaml -o out`, with s.yaml made of this text, and more arguments.
  ProgramResult run(const std::string& yaml, const std::vector<std::string>& more = {}) const {
    write("s.yaml", yaml);
    ProgramCall call{
        .arguments = {"run", "s.yaml", "-o", "out"}, .environment = {}, .folder = "", .interrupt_when = {}};
    call.arguments.insert(call.arguments.end(), more.begin(), more.end());
    return reamsim(call);
  }

  /// The program ended with this status, said why in one line that has all of these words, and left nothing behind.
  void expect_refused(const ProgramResult& result, int status, std::initializer_list<const char*> words) const {
    EXPECT_EQ(result.signal, 0) << "killed by a signal\n" << result.out << result.err;
    EXPECT_EQ(result.status, status) << result.out << result.err;
    int errors = 0;
    for (std::size_t at = 0; at < result.err.size();) {
      const std::size_t end = std::min(result.err.find('\n', at), result.err.size());
      const std::string line = result.err.substr(at, end - at);
      at = end + 1;
      if (line.starts_with("reamsim: warning: ")) continue;
      ++errors;
      EXPECT_TRUE(line.starts_with("reamsim: error: ")) << result.err;
      for (const char* word : words) EXPECT_THAT(line, ::testing::HasSubstr(word));
    }
    EXPECT_EQ(errors, 1) << "expected one line on stderr, found:\n" << result.err;
    EXPECT_FALSE(exists("out"));
    EXPECT_FALSE(exists("out.partial"));
  }
  void expect_done(const ProgramResult& result) const {
    EXPECT_EQ(result.status, 0) << result.signal << result.out << result.err;
    EXPECT_TRUE(exists("out/summary.json"));
    EXPECT_FALSE(exists("out.partial"));
  }

  TempDir temp_;
  const std::string dir_ = temp_.path();
  bool plots_ = false, meshes_ = false;
};

}  // namespace reamsim::test
