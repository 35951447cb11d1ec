// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/reforce.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "sim/base/error.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

const std::vector<std::string> kAxial{"axial_force_n", "spin_torque_nmm"};

TEST(MeasuredForcesFile, IsReadWithTheColumnsThatItHas) {
  const TempDir dir;
  const std::string path = dir.path() + "/measured.csv";
  std::ofstream(path) << "spin_torque_nmm,time_s,note,axial_force_n\n1,0.5,a,2\n,0.75,b,3\n";
  const MeasuredForces found = read_measured_forces(path);
  ASSERT_EQ(found.columns, kAxial);
  EXPECT_EQ(found.time_s, (std::vector{0.5, 0.75}));
  EXPECT_EQ(found.values[0], (std::vector{2.0, 3.0}));
  EXPECT_TRUE(std::isnan(found.values[1][1]));
  for (const char* bad :
       {"", "time_s\n1\n", "axial_force_n\n1\n", "time_s,axial_force_n\n", "time_s,axial_force_n\n1\n",
        "time_s,axial_force_n\n1,x\n", "time_s,axial_force_n\n1,1\n1,2\n", "time_s,axial_force_n\n1,nan\n"}) {
    std::ofstream(path, std::ios::trunc) << bad;
    EXPECT_THROW(read_measured_forces(path), InputError) << bad;
  }
}

TEST(MeasuredForcesFile, NamesTheSeparatorThatIsNoComma) {
  const TempDir dir;
  const std::string path = dir.path() + "/measured.csv";
  const auto expect_complaint = [&](const char* text, const char* complaint) {
    std::ofstream(path, std::ios::trunc) << text;
    try {
      read_measured_forces(path);
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(complaint));
    }
  };
  expect_complaint("time_s;axial_force_n\n1;2\n",
                   "measured.csv:1: semicolons separate the columns; save it with commas");
  expect_complaint("time_s\taxial_force_n\n1\t2\n", "measured.csv:1: tabulators separate the columns");
  expect_complaint("time_s,axial_force_n\n1;2\n", "measured.csv:2: semicolons separate the columns");
  std::ofstream(path, std::ios::trunc) << "\xef\xbb\xbftime_s,axial_force_n\r\n1,2\r\n";
  EXPECT_EQ(read_measured_forces(path).time_s, (std::vector{1.0})) << "what \"CSV UTF-8\" of a spreadsheet is";
}

}  // namespace
}  // namespace reamsim::test
