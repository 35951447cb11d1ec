// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/study_folder.h"

#include "sim/scenario/parse.h"
#include "tests/study/study_fixture.h"

namespace reamsim::test {
namespace {

constexpr KeptFiles kSummaryOnly{.forces = false, .grids = false, .pictures = false};

class RunId : public StudyTest {
 protected:
  [[nodiscard]] std::string id(const std::string& file, const std::vector<std::string>& overrides = {},
                               const KeptFiles& keep = kSummaryOnly) const {
    Checksums checksums;
    return run_id(parse_scenario(path(file), overrides), keep, checksums);
  }
};

TEST_F(RunId, DependsOnTheContentAndNotOnThePlace) {
  const std::string before = id("base.yaml");
  std::filesystem::create_directory(path("elsewhere"));
  for (const char* name : {"base.yaml", "flat.stl"}) {
    std::filesystem::copy_file(path(name), path(std::string("elsewhere/") + name));
  }
  EXPECT_EQ(id("elsewhere/base.yaml"), before);
  EXPECT_EQ(id("base.yaml", {"name=other"}), before);
  EXPECT_EQ(id("base.yaml", {"bone.voxel_mm=0.5"}), before) << "the resolved scenario is the same";
  EXPECT_EQ(id("base.yaml", {"output.vti=false"}), before);
  EXPECT_NE(id("base.yaml", {"output.force_basis=true"}), before) << "another file is wanted";
  EXPECT_NE(id("base.yaml", {"motion.plunge.depth_mm=2"}), before);
  EXPECT_NE(id("base.yaml", {"tool.mesh=convex.stl"}), before);
  std::filesystem::copy_file(path("convex.stl"), path("elsewhere/flat.stl"),
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_NE(id("elsewhere/base.yaml"), before) << "the mesh has another content";
}

TEST_F(RunId, CountsPicturesOnlyWhereTheyAreKept) {
  const KeptFiles with_pictures{.forces = true, .grids = true, .pictures = true};
  EXPECT_EQ(id("base.yaml", {"render.width_px=640"}), id("base.yaml"));
  EXPECT_NE(id("base.yaml", {"render.width_px=640"}, with_pictures), id("base.yaml", {}, with_pictures));
}

}  // namespace
}  // namespace reamsim::test
