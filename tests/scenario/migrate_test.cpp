// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>

#include "tests/scenario/scenario_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Scenarios of format version 1 and their keys.
class Migrate : public ScenarioTest {
 protected:
  /// kValid as version 1, with further sections.
  Scenario version_1(const std::string& more) { return parse(with(kValid, "version: 2", "version: 1") + more); }
};

TEST_F(Migrate, Version1WithoutOldKeysMeansTheSame) {
  const Scenario old = version_1("");
  EXPECT_THAT(old.notes, IsEmpty());
  EXPECT_EQ(to_yaml(old), to_yaml(parse(kValid)));
  EXPECT_THAT(to_yaml(old), HasSubstr("version: 2\n"));
}

TEST_F(Migrate, TheDetectorIsTheEngine) {
  const Scenario old = version_1("engine: {detector: octree}\n");
  EXPECT_EQ(old.engine.type, EngineKind::octree);
  EXPECT_EQ(engine_of(old), EngineKind::octree);
  EXPECT_THAT(
      old.notes,
      ElementsAre(HasSubstr("s.yaml:16:10: engine.detector: outdated since format version 2: write engine.type")));
  EXPECT_THAT(complaint(kValid + "engine:\n  detector: fast\n"),
              HasSubstr("s.yaml:17:13: engine.type: found the text \"fast\""));
}

TEST_F(Migrate, BrickedWasTheEngineOfEveryErosion) {
  const std::string bricked = "engine: {detector: bricked}\n";
  EXPECT_EQ(engine_of(version_1(bricked)), EngineKind::exact);
  EXPECT_EQ(engine_of(version_1(bricked + "cutting: {erosion: exact}\n")), EngineKind::exact);
  EXPECT_EQ(engine_of(version_1(bricked + "cutting: {erosion: wear}\n")), EngineKind::bricked);
  EXPECT_EQ(engine_of(version_1(bricked + "cutting: {law: per_point}\n")), EngineKind::bricked);
  EXPECT_EQ(engine_of(parse(kValid + "engine: {type: bricked}\n")), EngineKind::bricked) << "in version 2";
}

TEST_F(Migrate, OldNamesOfKeys) {
  const Scenario old =
      version_1("cutting: {friction_share: 0.25, size_effect: {exponent: 0.3, reference_mm: 0.05, lips: 6}}\n");
  EXPECT_EQ(old.cutting.friction_fraction, 0.25);
  EXPECT_EQ(old.cutting.size_effect->cutting_edges, 6);
  EXPECT_EQ(old.notes.size(), 2U);
  const Scenario edge = version_1("cutting: {edge_force: {tangential_n_mm: 1, normal_n_mm: 0, lips: 3}}\n");
  EXPECT_EQ(edge.cutting.edge_force->cutting_edges, 3);
}

TEST_F(Migrate, SpeedOnlyKeysAreIgnoredWithANote) {
  const std::string speed_only = "engine: {kernel_shape: gpu, culling: false, work_group_size: 16, batch_frames: 4}\n";
  for (const std::string& yaml : {kValid + speed_only, with(kValid, "version: 2", "version: 1") + speed_only}) {
    const Scenario s = parse(yaml);
    EXPECT_EQ(s.engine.batch_frames, 4);
    EXPECT_TRUE(s.engine.tuning.culling);
    ASSERT_EQ(s.notes.size(), 3U);
    for (const std::string& note : s.notes)
      EXPECT_THAT(note, HasSubstr("ignored, because it changes no result: remove it"));
    EXPECT_EQ(to_yaml(s), to_yaml(parse(kValid + "engine: {batch_frames: 4}\n")));
  }
  EXPECT_THAT(parse(kValid, {"engine.kernel_shape=gpu"}).notes,
              ElementsAre(HasSubstr(
                  "--set engine.kernel_shape=gpu: engine.kernel_shape: ignored, because it changes no result")));
}

TEST_F(Migrate, BothNamesAreAnError) {
  EXPECT_EQ(complaint(kValid + "engine: {type: auto, detector: direct}\n"),
            "s.yaml:16:22: engine.detector: given together with type; expected type only");
}

TEST_F(Migrate, OtherVersionsAreAnError) {
  EXPECT_THAT(complaint(with(kValid, "version: 2", "version: 3")), HasSubstr("version: found 3; expected"));
  EXPECT_THAT(complaint(with(kValid, "version: 2", "version: 0")), HasSubstr("version: found 0; expected"));
  EXPECT_EQ(complaint(kValid + "engine: [detector]\n").substr(0, 20), "s.yaml:16:9: engine:");
}

TEST_F(Migrate, EngineAndErosionAgree) {
  EXPECT_THAT(complaint(kValid + "engine: {type: exact}\ncutting: {erosion: remove}\n"),
              HasSubstr("cutting.erosion: found remove; expected exact, because engine.type is exact"));
  EXPECT_THAT(complaint(kValid + "engine: {type: bricked}\ncutting: {erosion: exact}\n"),
              HasSubstr("cutting.erosion: found exact; expected remove or wear, because engine.type is bricked"));
  EXPECT_EQ(parse(kValid + "engine: {type: direct}\n").cutting.erosion, ErosionMode::remove);
  EXPECT_EQ(parse(kValid + "engine: {type: exact}\n").cutting.erosion, ErosionMode::exact);
}

}  // namespace
}  // namespace reamsim::test
