// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// tool.holder and clearance, from the command line.
#include "tests/cli/cli_fixture.h"
#include "tests/support/real_data.h"

namespace reamsim::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kWithHolder = with(kSmall, "motion:\n",
                                     "  holder:\n    - {name: shaft, from_z_mm: 12, to_z_mm: 60, diameter_mm: 8}\n"
                                     "    - {from_z_mm: 60, to_z_mm: 100, diameter_mm: 30, end_diameter_mm: 40}\n"
                                     "clearance: {least_mm: 10.9}\nmotion:\n");

class ClearanceCommand : public CliTest {};

TEST_F(ClearanceCommand, IsReportedAndWarnedOf) {
  const ProgramResult done = run(kWithHolder);
  expect_done(done);
  EXPECT_THAT(done.out, HasSubstr("clearance of the holder: at least 11.00 mm, shaft from the bone at ("));
  EXPECT_THAT(done.err, Not(HasSubstr("clearance")));
  const std::string summary = read("out/summary.json");
  EXPECT_NEAR(number_after(summary, "\"clearance\": {\n    \"least_mm\": "), 11, 0.05)
      << "the core that the bore of the reamer leaves, 1 mm over the floor of the hole";
  EXPECT_THAT(summary, AllOf(HasSubstr("\"part\": \"shaft\""), HasSubstr("\"obstacle\": \"bone\""),
                             HasSubstr("\"first_frame_below\": null")));
  EXPECT_TRUE(read("out/clearance.csv")
                  .starts_with("frame,time_s,clearance_mm,part,envelope,x_mm,y_mm,z_mm,pass\n0,0,12.5,1,0,"));
  EXPECT_THAT(read("out/manifest.json"), HasSubstr("clearance.csv"));
  write("s.yaml", with(kWithHolder, "least_mm: 10.9", "least_mm: 11.22"));
  const ProgramResult checked =
      reamsim({.arguments = {"check", "s.yaml"}, .environment = {}, .folder = "", .interrupt_when = {}});
  EXPECT_EQ(checked.status, 0) << checked.err;
  EXPECT_THAT(checked.out,
              AllOf(HasSubstr("# warning: clearance of the holder: at least 11.00 mm, shaft from the bone at ("),
                    HasSubstr("less than clearance.least_mm (11.22 mm) between frames 26 and "),
                    HasSubstr("end_diameter_mm: 40")));
}

TEST_F(ClearanceCommand, FromTheAcromionOfAScan) {
  if (!std::filesystem::exists(data_file("shoulder_ct/shoulder_left.nrrd"))) GTEST_SKIP() << "set REAMSIM_DATA";
  const auto check_mm = [&](const std::string& diameter_mm) {
    std::vector<std::string> arguments{"check", REAMSIM_ROOT "/trajectories/ct_shoulder.yaml", "--set",
                                       "tool.holder=[{from_z_mm: 20, to_z_mm: 180, diameter_mm: " + diameter_mm + "}]"};
    arguments.insert(arguments.end(), kQuickShoulder.begin(), kQuickShoulder.end());
    const ProgramResult checked =
        reamsim({.arguments = arguments, .environment = {}, .folder = "", .interrupt_when = {}});
    EXPECT_EQ(checked.status, 0) << checked.err;
    return number_after(checked.out, "clearance of the holder: at least ");
  };
  // The acromion lies beside the holder, so that the clearance is the distance from its axis less its radius.
  EXPECT_NEAR(check_mm("30") - check_mm("40"), 5, 0.04);
}

TEST_F(ClearanceCommand, MistakesAreInputErrors) {
  expect_refused(run(with(kWithHolder, "to_z_mm: 60,", "to_z_mm: 12,")), 2,
                 {"tool.holder.0.to_z_mm", "found 12", "more than from_z_mm, 12"});
  expect_refused(run(with(kWithHolder, "{least_mm: 10.9}", "{least_mm: 1, envelope: {path: none.stl}}")), 2,
                 {"clearance.envelope.path", "no such file"});
  // A limit that nothing is compared with.
  expect_refused(run(with(kSmall, "motion:\n", "clearance: {least_mm: 1}\nmotion:\n")), 2,
                 {"clearance.least_mm", "found 1", "expected tool.holder as well"});
  write("skin.stl", "not a mesh");
  expect_refused(run(with(kWithHolder, "{least_mm: 10.9}", "{least_mm: 1, envelope: {path: skin.stl}}")), 2,
                 {"skin.stl"});
}

}  // namespace
}  // namespace reamsim::test
