#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "render/render.h"
#include "sim/base/error.h"
#include "tests/render/picture_file.h"
#include "tests/support/temp_dir.h"

namespace reamsim {
namespace {

namespace fs = std::filesystem;

/// A log of `rows` frames of 1 ms; `force` scales everything but the time.
void write_log(const std::string& dir, int rows, double force) {
  std::ofstream csv(dir + "/forces.csv");
  csv << "frame,time_s,tool_x_mm,tool_y_mm,tool_z_mm,tool_qw,tool_qx,tool_qy,tool_qz,spin_rpm,spin_angle_rad,depth_mm,"
         "force_x_n,force_y_n,force_z_n,torque_x_nmm,torque_y_nmm,torque_z_nmm,axial_force_n,spin_torque_nmm,contacts,"
         "removed_mm3,energy_mj,floor_energy_mj,balance\n";
  for (int i = 1; i <= rows; ++i) {
    const double wave = force * (1 + std::sin(0.9 * i)) * std::min(1.0, i / (0.5 * rows));
    csv << i << ',' << 0.001 * i << ",0,0,0,1,0,0,0,250," << 0.026 * i << ',' << force * 0.0003 * i << ",0,0,0,0,0,0,"
        << 20 * wave << ',' << 400 * wave << ",10," << 0.02 * wave << ",0,0,0\n";
  }
}

class Plots : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* path = std::getenv("PATH");
    old_path_ = path == nullptr ? "" : path;
  }
  void TearDown() override { setenv("PATH", old_path_.c_str(), 1); }

  void expect_plots() const {
    const test::Picture plot = test::read_picture(dir_.path() + "/forces.png");
    EXPECT_EQ(plot.width, 1600);
    EXPECT_EQ(plot.at(2, 2), Eigen::Vector3i(255, 255, 255));
    EXPECT_THAT(test::file_bytes(dir_.path() + "/forces.svg"), ::testing::HasSubstr("</svg>"));
    EXPECT_TRUE(fs::exists(dir_.path() + "/forces.gp"));
  }
  void expect_failure(const std::string& words) const {
    try {
      write_force_plots(dir_.path(), 0.25);
      ADD_FAILURE() << "no complaint";
    } catch (const RunError& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr(words));
      EXPECT_THAT(error.what(), ::testing::Not(::testing::HasSubstr("\n")));
    }
  }
  /// Puts a program called gnuplot before the real one.
  void fake_gnuplot(const std::string& script) const {
    fs::create_directories(dir_.path() + "/bin");
    const std::string program = dir_.path() + "/bin/gnuplot";
    std::ofstream(program) << "#!/bin/sh\n" << script;
    fs::permissions(program, fs::perms::owner_all);
    setenv("PATH", (dir_.path() + "/bin:" + old_path_).c_str(), 1);
  }

  test::TempDir dir_;
  std::string old_path_;
};

TEST_F(Plots, ARunGivesFourCurves) {
  write_log(dir_.path(), 6000, 1);
  write_force_plots(dir_.path(), 0.25);
  expect_plots();
  const std::string svg = test::file_bytes(dir_.path() + "/forces.svg");
  for (const char* label :
       {"Axial force (N)", "Spin torque (N·mm)", "Removed volume (mm³)", "Depth (mm)", "Time (s)"}) {
    EXPECT_THAT(svg, ::testing::HasSubstr(label));
  }
  // Every curve's colour is there, each in its own quarter.
  const test::Picture plot = test::read_picture(dir_.path() + "/forces.png");
  const Eigen::Vector3i colors[] = {{0x00, 0x72, 0xb2}, {0xd5, 0x5e, 0x00}, {0x00, 0x9e, 0x73}, {0x8c, 0x4f, 0x86}};
  for (int panel = 0; panel < 4; ++panel) {
    int found = 0;
    for (int y = panel * plot.height / 4; y < (panel + 1) * plot.height / 4; ++y) {
      for (int x = 0; x < plot.width; ++x) found += (plot.at(x, y) - colors[panel]).cwiseAbs().maxCoeff() < 12 ? 1 : 0;
    }
    EXPECT_GT(found, 500) << "panel " << panel;
  }
}

TEST_F(Plots, FramesSpeakForThemselvesWhereVoxelsAreClipped) {
  CuttingSettings cutting;
  cutting.erosion = "exact";
  ASSERT_EQ(averaged_travel_mm(cutting, 0.25), 0);
  write_log(dir_.path(), 2000, 1);
  write_force_plots(dir_.path(), 0);
  expect_plots();
  EXPECT_THAT(test::file_bytes(dir_.path() + "/forces.svg"), ::testing::Not(::testing::HasSubstr("mean over")));
  cutting.erosion = "remove";
  write_force_plots(dir_.path(), averaged_travel_mm(cutting, 0.25));
  EXPECT_THAT(test::file_bytes(dir_.path() + "/forces.svg"), ::testing::HasSubstr("mean over 0.25 mm"));
}

TEST_F(Plots, AllZeroColumnsAndASingleRowHaveAxesToo) {
  write_log(dir_.path(), 2000, 0);
  write_force_plots(dir_.path(), 0.25);
  expect_plots();
  write_log(dir_.path(), 1, 0);
  write_force_plots(dir_.path(), 0.25);
  expect_plots();
}

TEST_F(Plots, AHundredThousandRowsAreDrawn) {
  write_log(dir_.path(), 100'000, 1);
  write_force_plots(dir_.path(), 0.25);
  expect_plots();
}

TEST_F(Plots, TheScriptRunsAgainByItselfInAnyFolderName) {
  const std::string dir = dir_.path() + "/a folder with 'quotes' and $signs";
  fs::create_directories(dir);
  write_log(dir, 50, 1);
  write_force_plots(dir, 0.25);
  EXPECT_TRUE(fs::exists(dir + "/forces.png"));
}

TEST_F(Plots, BadDataIsAnInputError) {
  EXPECT_THROW(write_force_plots(dir_.path(), 0.25), InputError);
  write_log(dir_.path(), 0, 1);
  EXPECT_THROW(write_force_plots(dir_.path(), 0.25), InputError);
}

TEST_F(Plots, WhatGnuplotSaysIsReported) {
  write_log(dir_.path(), 10, 1);
  fake_gnuplot("echo 'line 7: undefined mood' >&2\nexit 1\n");
  expect_failure("undefined mood");
  fake_gnuplot("exit 0\n");
  expect_failure("wrote nothing");
  setenv("PATH", (dir_.path() + "/empty").c_str(), 1);
  expect_failure("gnuplot");
}

}  // namespace
}  // namespace reamsim
