#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "reader_campaign.h"
#include "seeds.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {
namespace {

namespace fs = std::filesystem;

TEST(Readers, SeedsAreAccepted) {
  const TempDir folder;
  for (const Seed& seed : write_seeds(folder.path())) {
    const Verdict verdict = supervised([&] { load(seed.bone); });
    EXPECT_TRUE(verdict.accepted) << seed.reader << ": " << verdict.message << verdict.failure << verdict.signal;
  }
}

/// Files that once crashed a reader, or sent it into an endless loop or out of memory.
TEST(Readers, FilesThatOnceCrashedAreInputErrors) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(REAMSIM_CORPUS)) files.push_back(entry.path());
  std::ranges::sort(files);
  ASSERT_GE(files.size(), 5U);
  for (const fs::path& file : files) {
    const Verdict verdict = supervised([&] { load(bone_from_file(file.string())); });
    EXPECT_EQ(complaint_about(verdict, file.filename().string()), "") << file;
    EXPECT_FALSE(verdict.accepted) << file;
  }
}

TEST(Readers, DamagedFilesNeverCrash) {
  const Campaign campaign{.inputs = 380, .seed = 1, .keep = ""};
  for (const auto& [reader, findings] : run_campaign(campaign)) {
    for (const std::string& complaint : findings.complaints) {
      ADD_FAILURE() << reader << ", seed " << campaign.seed << ", " << complaint;
    }
    EXPECT_LT(findings.accepted, findings.inputs) << reader << ": no damage was found";
  }
}

}  // namespace
}  // namespace reamsim::test
