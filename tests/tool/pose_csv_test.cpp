// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Recorded poses: what is read, what is tolerated, and what is refused with file and line.
#include "sim/tool/motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "sim/base/error.h"
#include "tests/support/real_data.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string kHeader = "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz";

class PoseCsv : public testing::Test {
 protected:
  CsvMotionSettings saved(const std::string& bytes) {
    CsvMotionSettings settings;
    settings.path = dir_.path() + "/poses.csv";
    std::ofstream(settings.path, std::ios::binary) << bytes;
    return settings;
  }

  std::vector<KeyPose> read(const std::string& bytes) { return read_pose_csv(saved(bytes), report_); }

  std::string error_of(const std::string& bytes) { return error_of(saved(bytes)); }

  std::string error_of(const CsvMotionSettings& settings) {
    try {
      read_pose_csv(settings, report_);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  /// A good file whose third line (second row) is `row`.
  static std::string with_row(const std::string& row) { return kHeader + "\n0,0,0,0,1,0,0,0\n" + row + "\n"; }

  TempDir dir_;
  Diagnostics report_;
};

TEST_F(PoseCsv, ReadsWhatItSays) {
  const auto poses = read(kHeader + ",spin_rpm\n0.5,1,2,3,1,0,0,0,100\n1.5,-4e1,+5,.25,0,0,1,0,-200\n");
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[0].time_s, 0.5);
  EXPECT_EQ(poses[1].pose.position_mm, Vec3(-40, 5, 0.25));
  EXPECT_EQ(poses[1].pose.orientation.coeffs(), Quat(0, 0, 1, 0).coeffs());
  EXPECT_EQ(poses[0].pose.spin_rpm, 100);
  EXPECT_EQ(poses[1].pose.spin_rpm, -200);
  EXPECT_THAT(report_.warnings, IsEmpty());
}

TEST_F(PoseCsv, TakesTheSpinFromTheScenarioWhereTheFileHasNone) {
  CsvMotionSettings settings = saved(with_row("1,0,0,0,1,0,0,0"));
  settings.spin_rpm = 321;
  EXPECT_EQ(read_pose_csv(settings, report_)[1].pose.spin_rpm, 321);
}

TEST_F(PoseCsv, ToleratesWhatSpreadsheetsDo) {
  const auto poses = read(
      "\xef\xbb\xbf\r\n\"qw\", qx ,qy,qz,time_s,note,x_mm,y_mm,z_mm\r\n\r\n1,0,0,0, 0 ,start,1,2,3\r\n  \r\n"
      "1,0,0,0,1,end,4,5,6");
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[1].pose.position_mm, Vec3(4, 5, 6));
  EXPECT_THAT(report_.notes, ElementsAre(AllOf(HasSubstr("poses.csv:2"), HasSubstr("\"note\""))));
}

TEST_F(PoseCsv, IsResampledToTheFrameRate) {
  MotionSettings settings;
  settings.csv = saved(kHeader + "\n2.00,0,0,0,1,0,0,0\n2.03,3,0,0,1,0,0,0\n2.10,10,0,0,0.7071,0.7071,0,0\n");
  settings.csv->spin_rpm = 60;
  settings.frame_rate_hz = 100;
  const Motion m = build_motion(settings, std::nullopt, report_);
  ASSERT_EQ(m.poses.size(), 11u);
  for (std::size_t k = 0; k < m.poses.size(); ++k) {
    EXPECT_NEAR(m.poses[k].position_mm.x(), static_cast<double>(k), 1e-9);
    EXPECT_NEAR(m.poses[k].spin_angle_rad, 2 * std::numbers::pi * static_cast<double>(k) / 100, 1e-9);
  }
  EXPECT_NEAR(m.poses[3].orientation.angularDistance(Quat::Identity()), 0, 1e-7);
  EXPECT_NEAR(m.poses[10].orientation.angularDistance(Quat::Identity()), std::numbers::pi / 2, 1e-6);
  EXPECT_THAT(report_.warnings, IsEmpty()) << "four digits of a quaternion are only rounding";
}

TEST_F(PoseCsv, NamesFileLineAndFault) {
  const auto expect = [&](const std::string& row, const std::string& found) {
    EXPECT_THAT(error_of(with_row(row)), AllOf(HasSubstr("poses.csv:3: "), HasSubstr(found)));
  };
  expect("1,0,zero,0,1,0,0,0", "y_mm: found 'zero'");
  expect("1,0,,0,1,0,0,0", "y_mm: found ''");
  expect("1,0,1.5mm,0,1,0,0,0", "y_mm: found '1.5mm'");
  expect("1,0,0,nan,1,0,0,0", "z_mm: found 'nan'");
  expect("1,0,0,inf,1,0,0,0", "z_mm: found 'inf'");
  expect("1,0,0,1e999,1,0,0,0", "z_mm: found '1e999'");
  expect("1,0,0,1e7,1,0,0,0", "z_mm: found 1e+07; at most 1e+06 mm");
  expect("-1,0,0,0,1,0,0,0", "time_s is -1 after 0");
  expect("0,0,0,0,1,0,0,0", "times must increase");
  expect("1,0,0,0,0,0,0,0", "the quaternion has length 0");
  expect("1,0,0,0,1,0,0", "found 7 cells; expected 8");
  expect("1,0,0,0,1,0,0,0,5", "found 9 cells");
  expect("1;0;0;0;1;0;0;0", "semicolons separate the columns; save it with commas");
  expect("1", "found 1 cell;");
}

TEST_F(PoseCsv, RefusesWrongHeaders) {
  EXPECT_THAT(error_of("time_s,x_mm,y_mm,qw,qx,qy,qz\n"),
              AllOf(HasSubstr("poses.csv:1"), HasSubstr("z_mm: no such column")));
  EXPECT_THAT(error_of("0,0,0,0,1,0,0,0\n1,0,0,0,1,0,0,0\n"), HasSubstr("time_s: no such column"));
  EXPECT_THAT(error_of(kHeader + ",qx\n"), HasSubstr("qx: the column is given twice"));
  EXPECT_THAT(error_of("time_s,x_cm,y_mm,z_mm,qw,qx,qy,qz\n"), HasSubstr("x_mm: no such column"));
}

TEST_F(PoseCsv, NamesTheSeparatorThatIsNoComma) {
  const auto separated = [](char separator) {
    std::string bytes = with_row("1,0,0,0,1,0,0,0");
    std::ranges::replace(bytes, ',', separator);
    return bytes;
  };
  EXPECT_THAT(error_of(separated(';')),
              AllOf(HasSubstr("poses.csv:1: semicolons separate the columns"), HasSubstr("save it with commas")));
  EXPECT_THAT(error_of("\xef\xbb\xbf\r\n" + separated(';')), HasSubstr("poses.csv:2: semicolons separate"));
  EXPECT_THAT(error_of(separated('\t')), HasSubstr("poses.csv:1: tabulators separate the columns"));
}

TEST_F(PoseCsv, RefusesFilesThatHoldNoMotion) {
  EXPECT_THAT(error_of(""), HasSubstr("is empty"));
  EXPECT_THAT(error_of("\r\n\r\n  \n"), HasSubstr("is empty"));
  EXPECT_THAT(error_of(kHeader + "\n"), AllOf(HasSubstr("0 rows"), HasSubstr("at least two")));
  EXPECT_THAT(error_of(kHeader + "\n0,0,0,0,1,0,0,0\n"), HasSubstr("1 rows"));
}

TEST_F(PoseCsv, RefusesWhatIsNoFileOrNoText) {
  CsvMotionSettings settings;
  settings.path = dir_.path() + "/absent.csv";
  EXPECT_THAT(error_of(settings), AllOf(HasSubstr("absent.csv"), HasSubstr("no such file")));
  settings.path = dir_.path();
  EXPECT_THAT(error_of(settings), HasSubstr("it is a folder"));
  EXPECT_THAT(error_of(std::string(100'000, 'x')), HasSubstr("more than 65535 bytes"));
  EXPECT_THAT(error_of(std::string(1000, '\0')), HasSubstr("time_s: no such column"));
  const std::string binary = error_of(
      "\x7f"
      "ELF\x01\x02\x03\n\xff\xfe\n");
  EXPECT_THAT(binary, HasSubstr("time_s: no such column"));
  for (const char c : binary) EXPECT_GE(static_cast<unsigned char>(c), ' ') << "one printable line";
}

/// The same two poses as every recording below: at 10.5 s in (1, 2, 3), at 10.75 s in (-4, 5.5, 6), turned about z.
void expect_two_poses(const std::vector<KeyPose>& poses, const std::string& text) {
  ASSERT_EQ(poses.size(), 2u) << text;
  EXPECT_DOUBLE_EQ(poses[0].time_s, 10.5) << text;
  EXPECT_DOUBLE_EQ(poses[1].time_s, 10.75) << text;
  EXPECT_NEAR((poses[0].pose.position_mm - Vec3(1, 2, 3)).norm(), 0, 1e-12) << text;
  EXPECT_NEAR((poses[1].pose.position_mm - Vec3(-4, 5.5, 6)).norm(), 0, 1e-12) << text;
  EXPECT_EQ(poses[0].pose.orientation.coeffs(), Quat::Identity().coeffs()) << text;
  EXPECT_NEAR(poses[1].pose.orientation.angularDistance(Quat(0.8, 0, 0, 0.6)), 0, 1e-12) << text;
}

TEST_F(PoseCsv, ReadsATumTrajectory) {
  CsvMotionSettings settings = saved(
      "# timestamp tx ty tz qx qy qz qw\n10.5 0.001 0.002 0.003 0 0 0 1\n\n  10.75\t-0.004 0.0055  0.006 0 0 0.6 0.8 "
      "\r\n");
  settings.format = PoseFormat::tum;
  apply_format_defaults(settings);
  expect_two_poses(read_pose_csv(settings, report_), "tum");
  EXPECT_EQ(read_pose_csv(settings, report_)[0].pose.spin_rpm, 250);
  EXPECT_THAT(report_.warnings, IsEmpty());
  EXPECT_THAT(report_.notes, IsEmpty());
}

TEST_F(PoseCsv, ReadsTheOddTrajectory) {
  CsvMotionSettings settings;
  settings.path = data_file("odd_files/tracker_tum.txt");
  if (!std::filesystem::exists(settings.path)) GTEST_SKIP() << "no " << settings.path << "; set REAMSIM_DATA";
  settings.format = PoseFormat::tum;
  apply_format_defaults(settings);
  const auto poses = read_pose_csv(settings, report_);
  ASSERT_EQ(poses.size(), 120u);
  EXPECT_NEAR((poses.front().pose.position_mm - Vec3(0, 0.1, 3)).norm(), 0, 1e-9);
  EXPECT_NEAR((poses.back().pose.position_mm - Vec3(-0.0972, 0.0236, -2.95)).norm(), 0, 1e-9);
  EXPECT_NEAR(poses[1].time_s - poses[0].time_s, 0.035916, 1e-6);
}

TEST_F(PoseCsv, ReadsOtherRecordingsByDescription) {
  // A spreadsheet of a country with decimal commas.
  CsvMotionSettings settings = saved(
      "Tracker 3\nserial;17\nFrame;Zeit [ms];Tx [cm];Ty;Tz;Q0;Qx;Qy;Qz;rpm\n1;10500;0,1;0,2;0,3;1;0;0;0;100\n"
      "2;10750;-0,4;0,55;0,6;0,8;0;0;0,6;120\n");
  settings.separator = Separator::semicolon;
  settings.decimal = DecimalMark::comma;
  settings.skip_lines = 2;
  settings.time_column = "Zeit [ms]";
  settings.time_unit = TimeUnit::ms;
  settings.position_columns = {"Tx [cm]", "Ty", "Tz"};
  settings.position_unit = LengthUnit::cm;
  settings.quaternion_columns = {"Q0", "Qx", "Qy", "Qz"};
  settings.spin_column = "rpm";
  const auto poses = read_pose_csv(settings, report_);
  expect_two_poses(poses, "semicolons");
  EXPECT_EQ(poses[1].pose.spin_rpm, 120);
  EXPECT_THAT(report_.notes, ElementsAre(HasSubstr("ignored columns: \"Frame\"")));

  // EuRoC: the header is a comment, time in ns; and the same by numbers, where a header is seen as one.
  for (const std::string head : {"#timestamp [ns], p_x [m], p_y [m], p_z [m], q_w [], q_x [], q_y [], q_z []\n",
                                 "timestamp,x,y,z,w,i,j,k\n", ""}) {
    settings = saved(head + "10500000000,0.001,0.002,0.003,1,0,0,0\n10750000000,-0.004,0.0055,0.006,0.8,0,0,0.6\n");
    const bool names = head.starts_with('#');
    settings.time_column = names ? "timestamp [ns]" : "1";
    settings.time_unit = TimeUnit::ns;
    settings.position_columns = {names ? "p_x [m]" : "2", "3", "4"};
    settings.position_unit = LengthUnit::m;
    settings.quaternion_columns = {"5", "6", "7", "8"};
    expect_two_poses(read_pose_csv(settings, report_), head);
  }
  settings.quaternion_columns = {"5", "6", "7", "9"};
  EXPECT_THAT(error_of(settings), HasSubstr("found 8 columns, and no column 9"));
}

TEST_F(PoseCsv, AppliesRegistrationAndCalibration) {
  CsvMotionSettings settings = saved(with_row("1,10,0,0,0.7071067811865476,0,0,0.7071067811865476"));
  settings.marker_from_tool = TransformSettings{.translation_mm = {5, 0, 0}};
  settings.bone_from_tracker =
      TransformSettings{.translation_mm = {0, 0, 100}, .rotation = {{1, 0, 0}, {0, 0, -1}, {0, 1, 0}}};
  const auto poses = read_pose_csv(settings, report_);
  // The tool lies 5 mm along x of the marker: (10, 5, 0) in the tracker, and y of the tracker is z of the bone.
  EXPECT_NEAR((poses[1].pose.position_mm - Vec3(10, 0, 105)).norm(), 0, 1e-12);
  EXPECT_NEAR((poses[1].pose.orientation * Vec3::UnitX() - Vec3::UnitZ()).norm(), 0, 1e-12);
  settings.bone_from_tracker->rotation.clear();
  settings.bone_from_tracker->quaternion = Quat(std::sqrt(0.5), std::sqrt(0.5), 0, 0);
  EXPECT_NEAR((read_pose_csv(settings, report_)[1].pose.position_mm - Vec3(10, 0, 105)).norm(), 0, 1e-12);
}

TEST_F(PoseCsv, AGapIsAnErrorAndLostRowsAreSkipped) {
  const std::string lost = kHeader +
                           "\n1700000000.1,0,0,0,1,0,0,0\n1700000000.2,,,,,,,\n"
                           "1700000000.3,MISSING,nan,NaN,missing,,,\n1700000000.4,1,0,0,1,0,0,0\n";
  CsvMotionSettings settings = saved(lost);
  EXPECT_THAT(error_of(settings), HasSubstr("poses.csv:3: x_mm: found ''"));
  settings.max_gap_s = 0.5;
  EXPECT_EQ(read_pose_csv(settings, report_).size(), 2u);
  EXPECT_THAT(report_.notes, ElementsAre(HasSubstr("2 rows without a pose were skipped")));
  settings.max_gap_s = 0.25;
  EXPECT_THAT(error_of(settings), AllOf(HasSubstr("poses.csv:5: no pose for 0.3 s, from 1700000000.1 s to this row"),
                                        HasSubstr("at most 0.25 s is allowed")));
  settings = saved(with_row("1,0,0,,1,0,0,0"));
  settings.max_gap_s = 2;
  EXPECT_THAT(error_of(settings), HasSubstr("poses.csv:3: a part of the pose is missing"));
}

TEST_F(PoseCsv, NamesTheWayToReadOtherRecordings) {
  EXPECT_THAT(error_of("# t tx ty tz qx qy qz qw\n1 2 3 4 0 0 0 1\n"),
              AllOf(HasSubstr("time_s: no such column"), HasSubstr("other recordings: motion.csv.format")));
}

TEST_F(PoseCsv, WarnsOfQuaternionsThatAreNoUnitButNotEndlessly) {
  std::string bytes = kHeader + "\n";
  for (int i = 0; i < 50; ++i) bytes += std::to_string(i) + ",0,0,0,1.1,0,0,0\n";
  const auto poses = read(bytes);
  EXPECT_NEAR(poses[7].pose.orientation.norm(), 1, 1e-15);
  ASSERT_EQ(report_.warnings.size(), 4u);
  EXPECT_THAT(report_.warnings[0], AllOf(HasSubstr("poses.csv:2"), HasSubstr("length 1.1")));
  EXPECT_THAT(report_.warnings[3], HasSubstr("47 more rows"));
}

}  // namespace
}  // namespace reamsim::test
