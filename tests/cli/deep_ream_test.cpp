// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "tests/cli/cli_fixture.h"
#include "tests/support/real_data.h"

namespace reamsim::test {
namespace {

// A ream through the whole vault opens a breach of thousands of columns, which the depth map sorts into hole and rim.
TEST_F(CliTest, AReamThroughTheVaultOfARealShoulderStaysWithinTwoGigabytes) {
  const std::string scan = data_file("shoulder_ct/shoulder_left.nrrd");
  if (!std::filesystem::exists(scan)) GTEST_SKIP() << "no " << scan << "; set REAMSIM_DATA";
  const ProgramResult result = reamsim(
      {.arguments = {"run", REAMSIM_ROOT "/trajectories/ct_shoulder.yaml", "-o", "out", "--set",
                     "motion.plunge.depth_mm=24", "--set", "motion.frame_rate_hz=100", "--set", "render.enabled=false"},
       .environment = {},
       .folder = "",
       .interrupt_when = {}});
  expect_done(result);
  EXPECT_LT(result.peak_mb, 2000);
  EXPECT_TRUE(exists("out/depth_map.csv"));
}

}  // namespace
}  // namespace reamsim::test
