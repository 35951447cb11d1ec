// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "sim/study/study_plan.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {

/// A folder with a base scenario, base.yaml, and studies of it.
class StudyTest : public ::testing::Test {
 protected:
  StudyTest() {
    std::filesystem::copy_file(REAMSIM_ROOT "/assets/reamer_flat.stl", path("flat.stl"));
    std::filesystem::copy_file(REAMSIM_ROOT "/assets/reamer_convex.stl", path("convex.stl"));
    write(
        "base.yaml",
        "version: 2\n"
        "bone: {source: phantom, voxel_mm: 0.5, phantom: {shape: half_space, size_mm: [10, 10, 6]}}\n"
        "tool: {mesh: flat.stl}\n"
        "motion: {frame_rate_hz: 100, plunge: {entry_mm: [0, 0, 0], axis: [0, 0, -1], approach_mm: 0.5, feed_mm_s: 5,\n"
        "         depth_mm: 1, dwell_s: 0, retract_mm: 2, retract_mm_s: 20}}\n"
        "engine: {device: serial}\n");
  }

  [[nodiscard]] std::string path(const std::string& name) const { return dir_.path() + "/" + name; }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(path(name), std::ios::binary) << text;
  }
  /// The study of these lines, below version and base.
  [[nodiscard]] Study study(const std::string& lines) const {
    write("study.yaml", "version: 1\nbase: base.yaml\n" + lines);
    return read_study(path("study.yaml"));
  }
  /// What is wrong with it.
  [[nodiscard]] std::string mistakes(const std::string& lines) const {
    try {
      static_cast<void>(study(lines));
    } catch (const InputError& error) {
      return error.what();
    }
    ADD_FAILURE() << "accepted: " << lines;
    return "";
  }

 private:
  TempDir dir_;
};

}  // namespace reamsim::test
