// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The page of `reamsim preview` and what it refuses; tests/browser/preview_page.py uses it.
#include "tests/cli/cli_fixture.h"
#include "tests/cli/data_files.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Preview : public CliTest {
 protected:
  ProgramResult preview(const std::vector<std::string>& arguments) const {
    ProgramCall call{.arguments = {"preview"}, .environment = {}, .folder = "", .interrupt_when = {}};
    call.arguments.insert(call.arguments.end(), arguments.begin(), arguments.end());
    return reamsim(call);
  }
  /// The page of a scenario with this text.
  std::string page_of(const std::string& yaml) const {
    write("s.yaml", yaml);
    const ProgramResult result = preview({"s.yaml", "-o", "p.html", "--overwrite"});
    EXPECT_EQ(result.status, 0) << result.err;
    return read("p.html");
  }
};

const std::string kBlockScan =
    "  source: ct\n  voxel_mm: 0.5\n  ct:\n    path: block.nrrd\n    threshold_hu: 200\n    closing_mm: 0\n";

TEST_F(Preview, HoldsTheScenarioAsItIsWritten) {
  const std::string page = page_of(kSmall + "# at the end\n");
  EXPECT_THAT(page, HasSubstr("\\n# at the end\\n\",\"file_name\":\"s.yaml\""));
  EXPECT_FALSE(exists("p.html.tmp"));
}

TEST_F(Preview, WritesTheSamePageForTheSameInput) {
  EXPECT_EQ(page_of(kSmall), page_of(kSmall));
}

TEST_F(Preview, ShowsWhatStopsARun) {
  write("block.nrrd", block_nrrd());
  EXPECT_THAT(page_of(with_bone(kBlockScan)), HasSubstr("\"problems\":[]"));
  const std::string missed = page_of(with_bone(kBlockScan + "    seed_mm: [1, 1, 1]\n"));
  EXPECT_THAT(missed, HasSubstr("\"problems\":[\"block.nrrd: bone.ct.seed_mm: "));
  EXPECT_THAT(missed, HasSubstr("\"bone\":null")) << "there is no segmentation to show";
}

TEST_F(Preview, HoldsTheKeysOfAScanThatItDoesNotChange) {
  write("block.nrrd", block_nrrd());
  const std::string page = page_of(
      with_bone(kBlockScan + "    filter: median\n    crop_min_mm: [-50, -50, -50]\n    crop_max_mm: [50, 50, 50]\n"));
  EXPECT_THAT(page, HasSubstr("\"crop_min_mm\":[-50.0,-50.0,-50.0],\"crop_max_mm\":[50.0,50.0,50.0],\"filter\":"
                              "\"median, radius 1 voxels\""));
}

TEST_F(Preview, AcceptsAScenarioWhoseGlenoidIsStillToBePlaced) {
  write("block.nrrd", block_nrrd());
  const std::string yaml = with(with_bone(kBlockScan), "motion:\n", "motion:\n  frame: glenoid\n");
  write("s.yaml", yaml);
  EXPECT_EQ(reamsim({.arguments = {"check", "s.yaml"}, .environment = {}, .folder = "", .interrupt_when = {}}).status,
            2);
  EXPECT_THAT(page_of(yaml), HasSubstr("\"side\":null"));
}

TEST_F(Preview, PutsAScenarioTogetherForABareBone) {
  write("block.nrrd", block_nrrd());
  write("cube.stl", cube_stl(30));
  for (const char* bone : {"block.nrrd", "cube.stl"}) {
    const ProgramResult result = preview({bone, "-o", "p.html", "--overwrite"});
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_THAT(read("p.html"), HasSubstr("reamer_convex.stl"));
  }
  EXPECT_THAT(read("p.html"), HasSubstr("\"file_name\":\"cube.yaml\""));
}

TEST_F(Preview, FindsTheUnitOfAMeshAsInitDoes) {
  write("cube.stl", cube_stl(12));  // centimetres
  const ProgramResult found = preview({"cube.stl", "-o", "p.html"});
  EXPECT_EQ(found.status, 0) << found.err;
  EXPECT_THAT(found.err, HasSubstr("bone.mesh.scale: 10: the file is in centimetres; the mesh is then 120 mm long"));
  EXPECT_THAT(read("p.html"), HasSubstr("scale: 10 "));
  EXPECT_EQ(preview({"cube.stl", "-o", "p.html", "--scale", "3", "--overwrite"}).status, 0);
  EXPECT_THAT(read("p.html"), HasSubstr("scale: 3 "));
  expect_refused(preview({"cube.stl", "-o", "q.html", "--scale", "1000"}), 2, {"1.2e+04 mm long", "give --scale"});
  write("cube.stl", cube_stl(1.2));
  expect_refused(preview({"cube.stl", "-o", "q.html"}), 2, {"a unit that is unknown", "give --scale"});
  write("block.nrrd", block_nrrd());
  expect_refused(preview({"block.nrrd", "-o", "q.html", "--scale", "1"}), 2, {"block.nrrd", "only a mesh has a scale"});
}

TEST_F(Preview, RefusesWrongInputBeforeAnyWork) {
  write("s.yaml", kSmall);
  write("foreign.html", "a page of someone else");
  expect_refused(preview({"s.yaml"}), 2, {"required"});
  expect_refused(preview({"s.yaml", "-o", "p.txt"}), 2, {"p.txt", ".html"});
  expect_refused(preview({"nix.nrrd", "-o", "p.html"}), 2, {"nix.nrrd", "no such file"});
  expect_refused(preview({"s.yaml", "-o", "foreign.html"}), 2, {"foreign.html", "exists", "--overwrite"});
  expect_refused(preview({"s.yaml", "-o", "foreign.html", "--overwrite"}), 2,
                 {"foreign.html", "not a file that reamsim"});
  EXPECT_EQ(read("foreign.html"), "a page of someone else");
  expect_refused(preview({"s.yaml", "-o", "p.html", "--tool", "a.stl"}), 2, {"--tool", "tool.mesh"});
  write("bad.yaml", with(kSmall, "voxel_mm: 0.5", "voxel_mm: thick"));
  expect_refused(preview({"bad.yaml", "-o", "p.html"}), 2, {"bad.yaml:4:", "voxel_mm"});
}

}  // namespace
}  // namespace reamsim::test
