#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

// A ream through the whole vault opens a breach of thousands of columns, which the depth map sorts into hole and rim.
TEST_F(CliTest, AReamThroughTheVaultOfARealShoulderStaysWithinTwoGigabytes) {
  const char* given = std::getenv("REAMSIM_DATA");
  const std::string data = given != nullptr ? given : REAMSIM_ROOT "/../shared/data";
  if (!std::filesystem::exists(data + "/shoulder_ct/shoulder_left.nrrd")) {
    GTEST_SKIP() << "no real data in " << data << "; set REAMSIM_DATA to the folder that holds it";
  }
  const ProgramResult result = reamsim(
      {.arguments = {"run", REAMSIM_ROOT "/trajectories/ct_shoulder.yaml", "-o", "out", "--set",
                     "motion.plunge.depth_mm=24", "--set", "motion.frame_rate_hz=100", "--set", "render.enabled=false"},
       .environment = {{"REAMSIM_DATA", data}},
       .folder = "",
       .interrupt_when = {}});
  expect_done(result);
  EXPECT_LT(result.peak_mb, 2000);
  EXPECT_TRUE(exists("out/depth_map.png"));
}

}  // namespace
}  // namespace reamsim::test
