// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/force_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "sim/base/error.h"
#include "tests/support/temp_dir.h"

namespace reamsim {
namespace {

constexpr const char* kLogHeader =
    "frame,time_s,tool_x_mm,tool_y_mm,tool_z_mm,tool_qw,tool_qx,tool_qy,tool_qz,spin_angle_rad,depth_mm,force_x_n,"
    "force_y_n,force_z_n,axial_force_n,spin_torque_nmm,removed_mm3,energy_mj,"
    "floor_energy_mj,balance\n";

class ForceLogFile : public ::testing::Test {
 protected:
  ForceLog read(const std::string& text) {
    std::ofstream(path_, std::ios::binary) << text;
    return read_force_log(path_);
  }
  void expect_complaint(const std::string& text, const std::string& about) {
    try {
      read(text);
      ADD_FAILURE() << "no complaint about " << about;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr(about));
    }
  }

  test::TempDir dir_;
  std::string path_ = dir_.path() + "/forces.csv";
};

TEST_F(ForceLogFile, RowsAreReadAndVolumesSummed) {
  const ForceLog log = read(std::string(kLogHeader) + "1,0.001,1,2,3,1,0,0,0,0.5,0.1,3,4,5,10,100,2.5,4,1,0.5\r\n" +
                            "2,0.002,1,2,3,0,0,0,1,0.6,0.2,6,7,8,11,110,1.5,3,2,-0.5\n");
  ASSERT_EQ(log.rows.size(), 2U);
  EXPECT_EQ(log.rows[1].frame, 2);
  EXPECT_DOUBLE_EQ(log.rows[1].removed_mm3, 4.0);
  EXPECT_DOUBLE_EQ(log.rows[1].cumulative_energy_mj, 7.0);
  EXPECT_DOUBLE_EQ(log.rows[1].cumulative_floor_mj, 3.0);
  EXPECT_DOUBLE_EQ(log.rows[1].balance, -0.5);
  EXPECT_DOUBLE_EQ(log.rows[1].axial_force_n, 11);
  EXPECT_EQ(log.rows[1].force_n, Vec3(6, 7, 8));
  EXPECT_DOUBLE_EQ(log.rows[1].pose.orientation.z(), 1);
  EXPECT_EQ(&log.at(0, path_), &log.rows[0]);
  EXPECT_EQ(&log.at(2, path_), &log.rows[1]);
  EXPECT_THROW((void)log.at(3, path_), InputError);
}

TEST_F(ForceLogFile, ColumnsMayStandAnywhere) {
  const ForceLog log = read(
      "balance,floor_energy_mj,removed_mm3,energy_mj,other,frame,time_s,tool_x_mm,tool_y_mm,tool_z_mm,tool_qw,tool_qx,"
      "tool_qy,tool_qz,spin_"
      "angle_rad,"
      "depth_mm,axial_force_n,spin_torque_nmm,force_x_n,force_y_n,force_z_n\n0,0,7,8,x,1,0.5,0,0,0,1,0,0,0,0,0,0,0,0,0,"
      "0\n");
  EXPECT_DOUBLE_EQ(log.rows[0].removed_mm3, 7);
  EXPECT_DOUBLE_EQ(log.rows[0].time_s, 0.5);
}

// As SIGKILL within a write leaves it. The row may even have all its cells, the last without some digits.
TEST_F(ForceLogFile, ARowThatAKilledRunLeftIncompleteIsNotRead) {
  const std::string finished = path_, dir = dir_.path() + "/run.partial";
  std::filesystem::create_directory(dir);
  path_ = dir + "//./forces.csv";
  const std::string whole = std::string(kLogHeader) + "1,0,0,0,0,1,0,0,0,0,0,0,0,0,0,0,0,0,0,0\n";
  for (const char* part : {"2", "2,0,0,0", "2,0,0,0,0,1,0,0,0,0,0,0,0,0,0,0,0,0,0,-0.00"}) {
    EXPECT_EQ(read(whole + part).rows.size(), 1U) << part;
  }
  expect_complaint(kLogHeader + std::string("1,0,0"), "no row");
  path_ = finished;
  expect_complaint(whole + "2,0,0,0", "forces.csv:3");
}

TEST_F(ForceLogFile, MistakesAreNamedWithTheirLine) {
  EXPECT_THROW((void)read_force_log(dir_.path() + "/none.csv"), InputError);
  expect_complaint("", "forces.csv");
  expect_complaint("frame,time_s\n1,2\n", "tool_x_mm");
  expect_complaint(kLogHeader, "no row");
  const std::string good = std::string(kLogHeader) + "1,0,0,0,0,1,0,0,0,0,0,0,0,0,0,0,0,0,0,0\n";
  expect_complaint(good + "2,0,0,oops,0,1,0,0,0,0,0,0,0,0,0,0,0,0,0,0\n", "forces.csv:3: tool_y_mm: found 'oops'");
  expect_complaint(good + "2,0,0,nan,0,1,0,0,0,0,0,0,0,0,0,0,0,0,0,0\n", "tool_y_mm");
  expect_complaint(good + "2,0,0,0\n", "forces.csv:3");
  expect_complaint(good + "1,0,0,0,0,1,0,0,0,0,0,0,0,0,0,0,0,0,0,0\n", "ascend");
  expect_complaint(good + "2,0,0,0,0,1,1,0,0,0,0,0,0,0,0,0,0,0,0,0\n", "quaternion");
  // Steps along a path of this length are below the resolution of a double: a search along it never ended.
  expect_complaint(good + "2,0,0,1e17,0,1,0,0,0,0,0,0,0,0,0,0,0,0,0,0\n", "forces.csv:3: tool_x_mm: the position");
}

}  // namespace
}  // namespace reamsim
