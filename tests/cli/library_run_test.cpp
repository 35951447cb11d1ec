// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// reamsim::run_scenario() of the C++ library against `reamsim run`.
#include <algorithm>

#include "sim/api/reamsim/simulation.h"
#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

namespace fs = std::filesystem;

class LibraryRun : public CliTest {
 protected:
  /// Names of the files in a folder, relative to it.
  [[nodiscard]] std::vector<std::string> files_in(const std::string& dir) const {
    std::vector<std::string> out;
    for (const auto& entry : fs::recursive_directory_iterator(path(dir))) {
      if (entry.is_regular_file()) out.push_back(fs::relative(entry.path(), path(dir)).string());
    }
    std::ranges::sort(out);
    return out;
  }
};

TEST_F(LibraryRun, WithRenderHasTheFilesOfReamsimRun) {
  plots_ = true;
  write("s.yaml", with(kSmall, "  enabled: false\n", "  width_px: 64\n  height_px: 64\n  cameras: [oblique]\n"));
  ASSERT_EQ(reamsim({.arguments = {"run", "s.yaml", "-o", "program", "--quiet"},
                     .environment = {},
                     .folder = "",
                     .interrupt_when = {}})
                .status,
            0);
  const RunResults results = run_scenario(path("s.yaml"), {.set = {}, .dir = path("library")});
  EXPECT_EQ(results.dir, path("library"));
  EXPECT_FALSE(exists("library/reamed.png"));
  EXPECT_EQ(read("library/forces.csv"), read("program/forces.csv"));
  EXPECT_EQ(read("library/reamed.vdb"), read("program/reamed.vdb"));
  ASSERT_EQ(reamsim({.arguments = {"render", "library"}, .environment = {}, .folder = "", .interrupt_when = {}}).status,
            0);
  EXPECT_EQ(files_in("library"), files_in("program"));
  for (const std::string& file : files_in("program")) {
    // Times differ, and a PDF holds its date. report.html has the times of the summary.
    if (file.ends_with(".pdf") || file == "timings.csv" || file == "summary.json" || file == "report.html") continue;
    EXPECT_TRUE(read("library/" + file) == read("program/" + file)) << file;
  }
}

}  // namespace
}  // namespace reamsim::test
