// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <vector>

#include "reader_campaign.h"
#include "render/plots/plots.h"
#include "seeds.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {
namespace {

namespace fs = std::filesystem;

void expect_accepted(const std::vector<Seed>& seeds) {
  for (const Seed& seed : seeds) {
    const Verdict verdict = supervised([&] { seed.read(seed.folder + "/" + seed.files[0]); });
    EXPECT_TRUE(verdict.accepted) << seed.reader << ": " << verdict.message << verdict.failure << verdict.signal;
  }
}

TEST(Readers, SeedsAreAccepted) {
  const TempDir folder;
  expect_accepted(write_seeds(folder.path()));
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

void expect_no_complaints(const Campaign& campaign) {
  for (const auto& [reader, findings] : run_campaign(campaign)) {
    for (const std::string& complaint : findings.complaints) {
      ADD_FAILURE() << reader << ", seed " << campaign.seed << ", " << complaint;
    }
    EXPECT_LT(findings.accepted, findings.inputs) << reader << ": no damage was found";
  }
}

TEST(Readers, DamagedFilesNeverCrash) {
  expect_no_complaints({.inputs = 380, .seed = 1, .keep = ""});
}

TEST(Texts, SeedsAreAccepted) {
  const TempDir folder;
  expect_accepted(write_text_seeds(folder.path()));
}

/// Lists in lists, which overflowed the stack of those who read them.
TEST(Texts, DeepJsonIsDamaged) {
  const TempDir folder;
  const std::string deep = std::string(200'000, '[') + std::string(200'000, ']');
  std::ofstream(folder.path() + "/summary.json") << R"({"removed_mm3": 1, "forces": )" << deep << "}";
  const std::vector<ComparedRun> runs{{folder.path(), "a"}, {folder.path(), "b"}};
  const Verdict verdict = supervised([&] { compare_summaries(runs); });
  EXPECT_EQ(complaint_about(verdict, "summary.json"), "");
  EXPECT_FALSE(verdict.accepted);
}

TEST(Texts, DamagedFilesNeverCrash) {
  expect_no_complaints({.texts = true, .inputs = 105, .seed = 1, .keep = ""});
}

}  // namespace
}  // namespace reamsim::test
