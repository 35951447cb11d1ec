// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The progress of `reamsim import`.
#include <regex>
#include <sstream>

#include "tests/cli/cli_fixture.h"
#include "tests/cli/data_files.h"
#include "tests/support/real_data.h"

namespace reamsim::test {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;

class ImportTest : public CliTest {
 protected:
  /// The names of the stages in the log, after a look at their fractions.
  std::vector<std::string> stages_of(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "import");
    arguments.insert(arguments.end(), {"-o", "bone.vdb", "--overwrite"});
    const ProgramResult result =
        reamsim({.arguments = arguments, .environment = {}, .folder = "", .interrupt_when = {}});
    EXPECT_EQ(result.status, 0) << result.err;
    const std::regex form("import ([0-9]+) %(: ([^,]+))?(, ([0-9]+) s left)?");
    std::vector<std::string> names;
    int percent = 0;
    std::istringstream lines(result.out);
    for (std::string line; std::getline(lines, line);) {
      std::smatch parts;
      if (!line.starts_with("import ")) continue;
      if (!std::regex_match(line, parts, form)) {
        ADD_FAILURE() << line;
        continue;
      }
      const int now = std::stoi(parts[1]);
      EXPECT_TRUE(now == 0 || !names.empty()) << line;
      EXPECT_GE(now, percent) << result.out;
      EXPECT_TRUE(now == 2 || parts[5].matched == (now > 2)) << "a beginning says nothing of the rest: " << line;
      EXPECT_EQ(parts[3].matched, now < 100) << line;
      percent = now;
      if (parts[3].matched) names.push_back(parts[3]);
    }
    EXPECT_EQ(percent, 100) << result.out;
    return names;
  }
};

TEST_F(ImportTest, NamesTheStagesOfAMesh) {
  write("cube.stl", cube_stl(30));
  EXPECT_THAT(stages_of({"cube.stl", "--set", "bone.voxel_mm=0.5"}),
              ElementsAre("reading the mesh", "computing distances to its surface", "making voxels",
                          "placing the glenoid", "writing the VDB"));
}

TEST_F(ImportTest, NamesTheStagesOfAPhantomAndOfAVdb) {
  write("s.yaml", kSmall);
  EXPECT_THAT(stages_of({"s.yaml"}), ElementsAre("making voxels", "placing the glenoid", "writing the VDB"));
  std::filesystem::rename(path("bone.vdb"), path("first.vdb"));
  write("v.yaml", with_bone("  source: vdb\n  vdb:\n    path: first.vdb\n"));
  EXPECT_THAT(stages_of({"v.yaml"}), ElementsAre("reading the VDB", "placing the glenoid", "writing the VDB"));
}

TEST_F(ImportTest, NamesTheStagesOfACt) {
  write("block.nrrd", block_nrrd());
  EXPECT_THAT(stages_of({"block.nrrd"}),
              ElementsAre("reading the scan", "segmenting the bone", "correcting the density of its boundary",
                          "making voxels", "placing the glenoid", "writing the VDB"));
  EXPECT_THAT(stages_of({"block.nrrd", "--set", "bone.ct.filter=median"}), Contains("filtering the scan"));
}

TEST_F(ImportTest, NamesTheStagesOfTheRealBones) {
  const std::string scan = data_file("shoulder_ct/shoulder_left.nrrd");
  const std::string mesh = data_file("scapula_mesh/scapula_left.stl");
  if (!std::filesystem::exists(scan) || !std::filesystem::exists(mesh)) GTEST_SKIP() << "set REAMSIM_DATA";
  EXPECT_EQ(stages_of({scan, "--set", "bone.voxel_mm=2"}).size(), 6U);
  EXPECT_EQ(stages_of({mesh, "--set", "bone.voxel_mm=2", "--set", "bone.mesh.scale=55"}).size(), 5U);
}

TEST_F(ImportTest, QuietSaysNothing) {
  write("cube.stl", cube_stl(30));
  const ProgramResult result =
      reamsim({.arguments = {"import", "cube.stl", "-o", "bone.vdb", "--quiet", "--set", "bone.voxel_mm=1"},
               .environment = {},
               .folder = "",
               .interrupt_when = {}});
  EXPECT_EQ(result.out + result.err, "");
}

}  // namespace
}  // namespace reamsim::test
