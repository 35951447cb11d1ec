// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "render/pictures/run_view.h"
#include "render/plots/plots.h"
#include "render/render.h"
#include "sim/base/error.h"
#include "sim/bone/vdb/bone_vdb.h"
#include "sim/record/run_totals.h"
#include "tests/render/picture_file.h"
#include "tests/render/results_fixture.h"
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
        << 20 * wave << ',' << 400 * wave << ",10," << 0.02 * wave << ',' << 1.5 * force << ",0,0\n";
  }
}

/// All that is drawn from forces.csv.
void draw_all(const std::string& dir, double mean_travel_mm) {
  const ForceLog log = read_force_log(dir + "/forces.csv", {.mean_travel_mm = mean_travel_mm});
  write_force_plots(dir, log);
  write_depth_and_energy_plots(dir, log);
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
    EXPECT_EQ(plot.width, 2008) << "170 mm at 300 dpi";
    EXPECT_EQ(plot.at(2, 2), Eigen::Vector3i(255, 255, 255));
    EXPECT_THAT(test::file_bytes(dir_.path() + "/forces.svg"), ::testing::HasSubstr("</svg>"));
    for (const char* name : {"/forces", "/plots/forces_depth", "/plots/energy"}) {
      EXPECT_TRUE(fs::exists(dir_.path() + name + ".gp")) << name;
      EXPECT_TRUE(fs::exists(dir_.path() + name + ".png")) << name;
      EXPECT_TRUE(test::file_bytes(dir_.path() + name + ".pdf").starts_with("%PDF")) << name;
    }
  }
  void expect_failure(const std::string& words) const {
    try {
      draw_all(dir_.path(), 0.25);
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
  draw_all(dir_.path(), 0.25);
  expect_plots();
  const std::string svg = test::file_bytes(dir_.path() + "/forces.svg");
  for (const char* label :
       {"Axial force (N)", "Spin torque (N·mm)", "Removed volume (mm³)", "Tool depth (mm)", "Time (s)"}) {
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

/// The same log with contact from row `from` to row `to` only.
void leave_contact(const std::string& dir, int from, int to) {
  std::istringstream rows(test::file_bytes(dir + "/forces.csv"));
  std::ofstream csv(dir + "/forces.csv");
  std::string line;
  for (int i = 0; std::getline(rows, line); ++i) {
    if (i == 0 || (from <= i && i <= to)) {
      csv << line << '\n';
      continue;
    }
    const std::size_t depth = line.find(",250,");
    csv << line.substr(0, depth) << ",250," << 0.026 * i << ",0,0,0,0,0,0,0,0,0,0,0,0,0,0\n";
  }
}

TEST_F(Plots, TheTimeAxisIsThatOfContactUnlessTheUserAsksForTheWholeRun) {
  write_log(dir_.path(), 1000, 1);
  leave_contact(dir_.path(), 400, 700);
  const std::string log = test::file_bytes(dir_.path() + "/forces.csv");
  draw_all(dir_.path(), 0);
  const char* note = "without contact, not shown: 0.001–0.385 s and 0.715–1 s";
  for (const char* name : {"/forces.svg", "/plots/energy.svg"}) {
    EXPECT_THAT(test::file_bytes(dir_.path() + name), ::testing::HasSubstr(note)) << name;
  }
  EXPECT_EQ(test::file_bytes(dir_.path() + "/forces.csv"), log);
  // The script is the user's: it runs again as it is, and with the switch that it names.
  const std::string again = "cd " + dir_.path() + " && gnuplot -d -e 'whole_run = 1' ";
  for (const char* name : {"forces", "plots/energy"}) {
    ASSERT_EQ(std::system((again + name + ".gp").c_str()), 0);
    EXPECT_THAT(test::file_bytes(dir_.path() + "/" + name + ".svg"), ::testing::Not(::testing::HasSubstr("not shown")));
  }
}

/// The same log as that of two passes, the second after row `last`, with no contact between `from` and `to`.
void split_in_passes(const std::string& dir, int from, int last, int to) {
  std::istringstream rows(test::file_bytes(dir + "/forces.csv"));
  std::ofstream csv(dir + "/forces.csv");
  std::string line;
  for (int i = 0; std::getline(rows, line); ++i) {
    if (from < i && i < to) line = line.substr(0, line.find(",250,")) + ",250,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0";
    csv << line << (i == 0 ? ",pass" : i <= last ? ",1" : ",2") << '\n';
  }
}

TEST_F(Plots, TheTimeBetweenPassesIsNotShown) {
  write_log(dir_.path(), 1000, 1);
  split_in_passes(dir_.path(), 300, 500, 700);
  draw_all(dir_.path(), 0);
  for (const char* name : {"/forces.svg", "/plots/energy.svg"}) {
    const std::string svg = test::file_bytes(dir_.path() + name);
    EXPECT_THAT(svg, ::testing::HasSubstr("not shown: between passes")) << name;
    EXPECT_THAT(svg, ::testing::HasSubstr("pass 2")) << name;
  }
  // Ticks, every 0.1 s, have the times of the run, without those between the passes.
  const std::string forces = test::file_bytes(dir_.path() + "/forces.svg");
  EXPECT_THAT(forces, ::testing::HasSubstr(">0.8<"));
  EXPECT_THAT(forces, ::testing::Not(::testing::HasSubstr(">0.5<")));
  EXPECT_THAT(test::file_bytes(dir_.path() + "/plots/forces_depth.svg"), ::testing::HasSubstr("numbers: passes"));
  const std::string again = "cd " + dir_.path() + " && gnuplot -d -e 'whole_run = 1' forces.gp";
  ASSERT_EQ(std::system(again.c_str()), 0);
  EXPECT_THAT(test::file_bytes(dir_.path() + "/forces.svg"), ::testing::Not(::testing::HasSubstr("not shown")));
}

TEST_F(Plots, ARunInContactThroughoutIsShownWhole) {
  write_log(dir_.path(), 1000, 1);
  leave_contact(dir_.path(), 60, 960);
  draw_all(dir_.path(), 0);
  EXPECT_THAT(test::file_bytes(dir_.path() + "/forces.svg"), ::testing::Not(::testing::HasSubstr("not shown")));
}

TEST_F(Plots, ALongRunIsDecimatedWithItsPeaksAndSums) {
  constexpr int kRows = 6000;
  write_log(dir_.path(), kRows, 1);
  const ForceLog whole = read_force_log(dir_.path() + "/forces.csv");
  const ForceLog log = read_force_log(dir_.path() + "/forces.csv", {.keep = {1234}, .most_rows = 1000});
  ASSERT_TRUE(log.is_decimated());
  EXPECT_NO_THROW((void)log.at(1234, ""));
  EXPECT_EQ(key_results_of(log).peak_axial_force_n, key_results_of(whole).peak_axial_force_n);
  EXPECT_EQ(key_results_of(log).peak_spin_torque_nmm, key_results_of(whole).peak_spin_torque_nmm);
  write_force_plots(dir_.path(), log);
  write_depth_and_energy_plots(dir_.path(), log);
  expect_plots();
  EXPECT_THAT(test::file_bytes(dir_.path() + "/forces.gp"),
              ::testing::HasSubstr("csv = \"plots/forces_decimated.csv\""));
  static constexpr std::string_view kNames[] = {"axial_force_n", "removed_mm3", "energy_mj"};
  CsvReader drawn(dir_.path() + "/plots/forces_decimated.csv", kNames, "a plot's data");
  double peak_n = 0, removed_mm3 = 0, energy_mj = 0;
  for (std::vector<double> row; drawn.next(row);) {
    peak_n = std::max(peak_n, row[0]);
    removed_mm3 += row[1];
    energy_mj += row[2];
  }
  EXPECT_EQ(peak_n, key_results_of(whole).peak_axial_force_n);
  EXPECT_NEAR(removed_mm3, whole.rows.back().removed_mm3, 1e-9 * removed_mm3);
  EXPECT_NEAR(energy_mj, whole.rows.back().cumulative_energy_mj, 1e-9 * energy_mj);
}

TEST_F(Plots, FramesSpeakForThemselvesWhereVoxelsAreClipped) {
  CuttingSettings cutting;
  cutting.erosion = ErosionMode::exact;
  ASSERT_EQ(averaged_travel_mm(cutting, 0.25), 0);
  write_log(dir_.path(), 2000, 1);
  draw_all(dir_.path(), 0);
  expect_plots();
  EXPECT_THAT(test::file_bytes(dir_.path() + "/forces.svg"), ::testing::Not(::testing::HasSubstr("mean over")));
  cutting.erosion = ErosionMode::remove;
  draw_all(dir_.path(), averaged_travel_mm(cutting, 0.25));
  EXPECT_THAT(test::file_bytes(dir_.path() + "/forces.svg"), ::testing::HasSubstr("mean over 0.25 mm"));
}

TEST_F(Plots, AllZeroColumnsAndASingleRowHaveAxesToo) {
  write_log(dir_.path(), 2000, 0);
  draw_all(dir_.path(), 0.25);
  expect_plots();
  write_log(dir_.path(), 1, 0);
  draw_all(dir_.path(), 0.25);
  expect_plots();
}

TEST_F(Plots, AHundredThousandRowsAreDrawn) {
  write_log(dir_.path(), 100'000, 1);
  write_force_plots(dir_.path(), read_force_log(dir_.path() + "/forces.csv", {.mean_travel_mm = 0.25}));
  const test::Picture plot = test::read_picture(dir_.path() + "/forces.png");
  EXPECT_GT(plot.width, 1000);
}

TEST_F(Plots, TheScriptsRunAgainByThemselvesInAnyFolderName) {
  const std::string dir = dir_.path() + "/a folder with 'quotes' and $signs";
  fs::create_directories(dir);
  write_log(dir, 50, 1);
  draw_all(dir, 0.25);
  const std::string home = fs::current_path();
  fs::current_path(dir);
  for (const std::string name : {"forces", "plots/forces_depth", "plots/energy"}) {
    for (const char* ending : {".png", ".svg", ".pdf"}) EXPECT_TRUE(fs::remove(name + ending)) << name << ending;
    EXPECT_EQ(std::system(("gnuplot " + name + ".gp").c_str()), 0) << name;
    for (const char* ending : {".png", ".svg", ".pdf"}) EXPECT_TRUE(fs::exists(name + ending)) << name << ending;
  }
  fs::current_path(home);
}

TEST_F(Plots, TheEnergyPlotNamesPowerEnergyAndBalance) {
  write_log(dir_.path(), 600, 1);
  draw_all(dir_.path(), 0);
  const std::string energy = test::file_bytes(dir_.path() + "/plots/energy.svg");
  for (const char* label : {"Cutting power (W)", "Energy (J)", "Energy balance", "speed-floor energy"}) {
    EXPECT_THAT(energy, ::testing::HasSubstr(label));
  }
  // Every frame takes 1.5 mJ in 1 ms.
  EXPECT_THAT(test::file_bytes(dir_.path() + "/plots/energy.gp"), ::testing::HasSubstr(",1.5\n"));
  EXPECT_THAT(test::file_bytes(dir_.path() + "/plots/forces_depth.svg"), ::testing::HasSubstr("Tool depth (mm)"));
}

TEST_F(Plots, WhatWasRemovedIsCountedByDensity) {
  write_results(dir_.path(), {.voxel_mm = 0.8, .frames = 10, .every = 5});
  FilledVoxmap after = read_stored_bone(dir_.path() + "/reamed.vdb").voxmap;
  const double after_mm3 = after.bone_mm3();
  after.fill = FillBricks(after.grid.dims);
  const RunData run(dir_.path());
  write_removed_density(dir_.path(), {run.voxmap(), run.last_fill(), run.inputs().fill});
  std::ifstream csv(dir_.path() + "/plots/removed_density.csv");
  std::string line;
  ASSERT_TRUE(std::getline(csv, line));
  EXPECT_EQ(line, "density_from_g_cm3,density_to_g_cm3,removed_mm3");
  double sum_mm3 = 0, dense_mm3 = 0;
  int classes = 0;
  for (double from = 0, to = 0, removed = 0; std::getline(csv, line); ++classes) {
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf", &from, &to, &removed), 3) << line;
    sum_mm3 += removed;
    if (from < 1.55 && 1.55 <= to) dense_mm3 = removed;
    if (from >= 0.64 && to < 1.5) {
      EXPECT_EQ(removed, 0) << "there is no such bone: " << line;
    }
  }
  EXPECT_EQ(classes, 50);
  EXPECT_NEAR(sum_mm3, after.bone_mm3() - after_mm3, 1e-9 * sum_mm3);
  EXPECT_GT(dense_mm3, 0.3 * sum_mm3) << "the bone's dense outside";
  EXPECT_GT(fs::file_size(dir_.path() + "/plots/removed_density.pdf"), 1000u);
}

TEST_F(Plots, BoneOfOneDensityGetsASentenceInPlaceOfAHistogram) {
  FilledVoxmap bone;
  bone.grid = {.dims = {8, 8, 8}, .voxel_mm = 0.5, .origin_mm = Vec3::Zero()};
  bone.grade = GradeBricks(bone.grid.dims);
  for (int i = 0; i < 8; ++i) bone.grade.set({i, 0, 0}, 137);
  const FillBricks before(bone.grid.dims);
  FillBricks after = before;
  const auto svg = [&] {
    write_removed_density(dir_.path(), {bone, after, before});
    return test::file_bytes(dir_.path() + "/plots/removed_density.svg");
  };
  EXPECT_THAT(svg(), ::testing::HasSubstr("No bone was removed"));
  for (int i = 0; i < 4; ++i) after.set({i, 0, 0}, 0);
  EXPECT_THAT(svg(), ::testing::AllOf(::testing::HasSubstr("0.5 mm³ removed, 100 % of it"),
                                      ::testing::HasSubstr("1.08 to 1.12 g/cm³")));
  bone.grade.set({1, 0, 0}, 20);
  EXPECT_THAT(svg(), ::testing::Not(::testing::HasSubstr("histogram")));
}

TEST_F(Plots, BadDataIsAnInputError) {
  EXPECT_THROW(draw_all(dir_.path(), 0.25), InputError);
  write_log(dir_.path(), 0, 1);
  EXPECT_THROW(draw_all(dir_.path(), 0.25), InputError);
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
