// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>

#include "tests/scenario/scenario_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::ElementsAre;
using ::testing::StartsWith;

class Overrides : public ScenarioTest {};

TEST_F(Overrides, ChangeAddAndReachIntoLists) {
  const Scenario s =
      parse(kValid, {"bone.voxel_mm=0.25", "engine.batch_frames=4", "motion.keyframes.1.time_s=2.5",
                     "bone.phantom.size_mm=[4, 5, 6]", "bone.phantom.size_mm.0=8", "render.enabled=true"});
  EXPECT_EQ(s.bone.voxel_mm, 0.25);
  EXPECT_EQ(s.engine.batch_frames, 4);
  EXPECT_EQ(s.motion.keyframes[1].time_s, 2.5);
  EXPECT_EQ(s.motion.keyframes[0].time_s, 0);
  EXPECT_EQ(s.bone.phantom.size_mm, Vec3(8, 5, 6));
  EXPECT_TRUE(s.render.enabled);
}

TEST_F(Overrides, LaterOnesWin) {
  EXPECT_EQ(parse(kValid, {"bone.voxel_mm=0.25", "bone.voxel_mm=1"}).bone.voxel_mm, 1);
}

TEST_F(Overrides, ListsAndSections) {
  const Scenario s = parse(kValid, {"render.cameras=[section, glenoid]", "motion.keyframes=null",
                                    "motion.plunge={feed_mm_s: 2, depth_mm: 1}"});
  EXPECT_THAT(s.render.cameras, ElementsAre(CameraView::section, CameraView::glenoid));
  EXPECT_TRUE(s.motion.keyframes.empty());
  EXPECT_EQ(s.motion.plunge->feed_mm_s, 2);
}

TEST_F(Overrides, TextsAreLiteral) {
  for (const std::string name : {"Intel(R) Xeon(R): 2 #cores", "3090", "true", "null #", "a: b", "*x", "%"}) {
    EXPECT_EQ(parse(kValid, {"engine.device=" + name}).engine.device, name);
  }
  EXPECT_EQ(parse(kValid, {"engine.device=\"quoted\""}).engine.device, "quoted");
  EXPECT_EQ(parse(kValid, {"engine.device=a=b"}).engine.device, "a=b");
}

TEST_F(Overrides, DoNotTouchWhatAnAliasShares) {
  const std::string yaml = with(with(kValid, "position_mm: [0, 0, 1]", "position_mm: &p [0, 0, 1]"),
                                "position_mm: [0, 0, -1]", "position_mm: *p");
  const Scenario s = parse(yaml, {"motion.keyframes.1.position_mm.2=-3"});
  EXPECT_EQ(s.motion.keyframes[0].position_mm, Vec3(0, 0, 1));
  EXPECT_EQ(s.motion.keyframes[1].position_mm, Vec3(0, 0, -3));
}

TEST_F(Overrides, ErrorsNameTheAssignment) {
  const auto says = [&](const std::string& assignment) { return complaint(kValid, {assignment}); };
  EXPECT_EQ(says("bone.voxel_mm=9"),
            "--set bone.voxel_mm=9: bone.voxel_mm: found 9; expected a number, 0.01 to 5 (mm)");
  EXPECT_EQ(says("bone.voxl_mm=1"), "--set bone.voxl_mm=1: bone.voxl_mm: unknown key; did you mean voxel_mm (mm)?");
  EXPECT_EQ(says("bone.voxel_mm"), "--set bone.voxel_mm: found no \"=\"; expected --set key.path=value");
  EXPECT_EQ(says("=1"), "--set =1: found an empty key; expected --set key.path=value");
  EXPECT_EQ(says("bone..x=1"), "--set bone..x=1: found an empty key; expected --set key.path=value");
  EXPECT_EQ(
      says("bone.voxel_mm.x=1"),
      "--set bone.voxel_mm.x=1: found keys below bone.voxel_mm, which is 0.5; expected --set bone.voxel_mm=value");
  EXPECT_EQ(says("motion.keyframes.2.time_s=1"),
            "--set motion.keyframes.2.time_s=1: found 2 where an index into a list of 2 should be; expected 0 to 1");
  EXPECT_EQ(
      says("motion.keyframes.first.time_s=1"),
      "--set motion.keyframes.first.time_s=1: found first where an index into a list of 2 should be; expected 0 to "
      "1");
  EXPECT_EQ(
      says("motion.keyframes.1.time_s=-0.5"),
      "--set motion.keyframes.1.time_s=-0.5: motion.keyframes.1.time_s: found -0.5; expected a number, 0 to 100000 "
      "(s)");
  EXPECT_THAT(says("bone.phantom.size_mm=[1,"), StartsWith("--set bone.phantom.size_mm=[1,"));
  EXPECT_THAT(says("bone.voxel_mm="),
              StartsWith("--set bone.voxel_mm=: bone.voxel_mm: found the text \"\"; expected a number"));
  EXPECT_THAT(says("tool.mesh=nix.stl"), StartsWith("--set tool.mesh=nix.stl: tool.mesh: no such file: nix.stl"));
}

class ImportSettings : public ScenarioTest {
 protected:
  std::string complaint_of(const std::string& source, const std::string& file,
                           const std::vector<std::string>& overrides) const {
    try {
      parse_bone_settings(source, path(file), overrides);
    } catch (const InputError& error) {
      return without_dir(error.what());
    }
    return "";
  }
};

TEST_F(ImportSettings, TakeSourcePathAndOverrides) {
  const BoneSettings bone = parse_bone_settings("mesh", path("tool.stl"), {"bone.voxel_mm=0.75", "bone.mesh.scale=55"});
  EXPECT_EQ(bone.source, BoneSource::mesh);
  EXPECT_EQ(bone.mesh.path, path("tool.stl"));
  EXPECT_EQ(bone.mesh.scale, 55);
  EXPECT_EQ(bone.voxel_mm, 0.75);
}

TEST_F(ImportSettings, Complain) {
  EXPECT_EQ(complaint_of("ct", "nix.nrrd", {}),
            "nix.nrrd: bone.ct.path: no such file: nix.nrrd; expected a file or a folder that exists");
  EXPECT_EQ(complaint_of("mesh", "tool.stl", {"render.enabled=true"}),
            "--set render.enabled=true: not a key of the bone section; expected bone.KEY=VALUE");
  EXPECT_THAT(complaint_of("mesh", "tool.stl", {"bone.mesh.scale=0"}),
              StartsWith("--set bone.mesh.scale=0: bone.mesh.scale: found 0; expected a number, 0.000001 to 1000000"));
}

TEST_F(ImportSettings, RenderSettingsDoNotAskForInputs) {
  write("r.yaml", "version: 2\ntool: {mesh: gone.stl}\nrender: {width_px: 640}\n");
  const RenderSettings render = parse_result_settings(path("r.yaml"), {"render.height_px=480"}).render;
  EXPECT_EQ(render.width_px, 640);
  EXPECT_EQ(render.height_px, 480);
  EXPECT_EQ(parse_result_settings(path("r.yaml")).render.height_px, RenderSettings{}.height_px);
}

}  // namespace
}  // namespace reamsim::test
