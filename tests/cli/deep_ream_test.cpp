// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <sstream>

#include "tests/cli/cli_fixture.h"
#include "tests/support/real_data.h"

namespace reamsim::test {
namespace {

using DeepReam = CliTest;

// A ream through the whole vault opens a breach of thousands of columns, which the depth map sorts into hole and rim.
TEST_F(DeepReam, AReamThroughTheVaultOfARealShoulderStaysWithinTwoGigabytes) {
  const std::string scan = data_file("shoulder_ct/shoulder_left.nrrd");
  if (!std::filesystem::exists(scan)) GTEST_SKIP() << "no " << scan << "; set REAMSIM_DATA";
  std::vector<std::string> arguments{"run",   REAMSIM_ROOT "/trajectories/ct_shoulder.yaml",
                                     "-o",    "out",
                                     "--set", "motion.plunge.depth_mm=24",
                                     "--set", "motion.frame_rate_hz=50"};
  arguments.insert(arguments.end(), kQuickShoulder.begin(), kQuickShoulder.end());
  const ProgramResult result = reamsim({.arguments = arguments, .environment = {}, .folder = "", .interrupt_when = {}});
  expect_done(result);
  EXPECT_LT(result.peak_mb, 2000);
  std::istringstream map(read("out/depth_map.csv"));
  int without_bone = 0;
  for (std::string row; std::getline(map, row);) without_bone += row.find(",,") != std::string::npos ? 1 : 0;
  EXPECT_GT(without_bone, 2000) << "columns of the breach";
}

}  // namespace
}  // namespace reamsim::test
