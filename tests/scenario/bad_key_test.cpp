// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>

#include "tests/scenario/scenario_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

class BadKey : public ScenarioTest {
 protected:
  /// The complaint after one passage of the valid scenario was replaced.
  std::string changed(const std::string& from, const std::string& to) const {
    return complaint(with(kValid, from, to));
  }
};

TEST_F(BadKey, NothingToComplainOf) {
  EXPECT_EQ(complaint(kValid), "");
}

TEST_F(BadKey, UnknownNearestIsSuggested) {
  EXPECT_EQ(changed("voxel_mm", "voxl_mm"), "s.yaml:4:3: bone.voxl_mm: unknown key; did you mean voxel_mm (mm)?");
  EXPECT_EQ(changed("render:", "rendre:"), "s.yaml:14:1: rendre: unknown key; did you mean render?");
  EXPECT_EQ(changed("  source: phantom", "  Source: phantom"),
            "s.yaml:3:3: bone.Source: unknown key; did you mean source?");
  EXPECT_EQ(changed("time_s: 1", "time_s: 1, spin: 3"),
            "s.yaml:13:19: motion.keyframes.1.spin: unknown key; did you mean spin_rpm (rpm)?");
}

TEST_F(BadKey, UnknownFarFromEverythingListsWhatThereIs) {
  EXPECT_EQ(
      changed("  mesh: tool.stl", "  mesh: tool.stl\n  colour_of_handle: red"),
      "s.yaml:10:3: tool.colour_of_handle: unknown key; expected one of mesh, scale, shell_resolution, spin or holder");
}

TEST_F(BadKey, UnknownButRightElsewhere) {
  EXPECT_EQ(changed("version: 2\n", "version: 2\nvoxel_mm: 1\n"),
            "s.yaml:2:1: voxel_mm: unknown key; did you mean bone.voxel_mm?");
}

TEST_F(BadKey, WrongUnitSuffix) {
  EXPECT_THAT(complaint("version: 2\nmotion:\n  plunge:\n    feed_mm_min: 60\n"),
              HasSubstr("s.yaml:4:5: motion.plunge.feed_mm_min: unknown key; did you mean feed_mm_s (mm/s)?"));
  EXPECT_EQ(changed("voxel_mm", "voxel_cm"), "s.yaml:4:3: bone.voxel_cm: unknown key; did you mean voxel_mm (mm)?");
  EXPECT_EQ(changed("voxel_mm", "voxel"), "s.yaml:4:3: bone.voxel: unknown key; did you mean voxel_mm (mm)?");
  EXPECT_EQ(changed("time_s: 1", "time_ms: 1000"),
            "s.yaml:13:8: motion.keyframes.1.time_ms: unknown key; did you mean time_s (s)?");
}

TEST_F(BadKey, UnknownKeyWithControlCharactersStaysOnOneLine) {
  EXPECT_EQ(changed("voxel_mm:", "\"vox\\nel\\e[2J\":"),
            "s.yaml:4:3: bone.\"vox\\x0ael\\x1b[2J\": unknown key; expected one of source, side, voxel_mm, cache, "
            "surface_voxels, density, glenoid, "
            "phantom, ct, mesh, vdb or pilot_hole");
}

TEST_F(BadKey, Missing) {
  EXPECT_THAT(changed("version: 2\n", ""), StartsWith("s.yaml: version: missing; expected"));
  EXPECT_THAT(changed("  source: phantom\n", ""),
              StartsWith("s.yaml:2:1: bone.source: missing; expected this key: phantom, ct, mesh or vdb"));
  EXPECT_THAT(changed("  mesh: tool.stl\n", "  scale: 1\n"), StartsWith("s.yaml:8:1: tool.mesh: missing; expected"));
  EXPECT_THAT(changed("position_mm: [0, 0, -1], ", ""),
              StartsWith("s.yaml:13:7: motion.keyframes.1.position_mm: missing; expected"));
  EXPECT_THAT(complaint("version: 2\n"), StartsWith("s.yaml: bone: missing; expected"));
}

TEST_F(BadKey, WrongType) {
  EXPECT_EQ(changed("voxel_mm: 0.5", "voxel_mm: fine"),
            "s.yaml:4:13: bone.voxel_mm: found the text \"fine\"; expected a number, 0.01 to 5 (mm)");
  EXPECT_EQ(changed("voxel_mm: 0.5", "voxel_mm: \"0.5\""),
            "s.yaml:4:13: bone.voxel_mm: found the text \"0.5\"; expected a number, 0.01 to 5 (mm)");
  EXPECT_EQ(changed("voxel_mm: 0.5", "voxel_mm: 0.5 mm"),
            "s.yaml:4:13: bone.voxel_mm: found the text \"0.5 mm\"; expected a number, 0.01 to 5 (mm)");
  EXPECT_EQ(changed("voxel_mm: 0.5", "voxel_mm: [0.5]"),
            "s.yaml:4:13: bone.voxel_mm: found a list of 1; expected a number, 0.01 to 5 (mm)");
  EXPECT_EQ(changed("voxel_mm: 0.5", "voxel_mm: 0x10").substr(0, 30), "s.yaml:4:13: bone.voxel_mm: fo");
  EXPECT_EQ(changed("voxel_mm: 0.5", "voxel_mm:"),
            "s.yaml:4:3: bone.voxel_mm: found nothing; expected a number, 0.01 to 5 (mm)");
  EXPECT_EQ(changed("enabled: false", "enabled: no"),
            "s.yaml:15:12: render.enabled: found the text \"no\"; expected true or false");
  EXPECT_EQ(changed("version: 2", "version: 2.0"), "s.yaml:1:10: version: found 2.0; expected a whole number, 2");
  EXPECT_EQ(changed("mesh: tool.stl", "mesh: 7"),
            "s.yaml:9:9: tool.mesh: found 7; expected a path (in quotes where it looks like a number)");
  EXPECT_EQ(changed("tool:\n  mesh: tool.stl", "tool: tool.stl"),
            "s.yaml:8:7: tool: found the text \"tool.stl\"; expected a section of keys");
  EXPECT_EQ(
      changed("[10, 10, 6]", "[10, 10]"),
      "s.yaml:7:14: bone.phantom.size_mm: found a list of 2; expected 3 numbers [x, y, z], each 0.5 to 1000 (mm)");
  EXPECT_EQ(
      changed("[10, 10, 6]", "[10, x, 6]"),
      "s.yaml:7:19: bone.phantom.size_mm: found the text \"x\"; expected 3 numbers [x, y, z], each 0.5 to 1000 (mm)");
}

TEST_F(BadKey, OutOfRange) {
  EXPECT_EQ(changed("voxel_mm: 0.5", "voxel_mm: 0"),
            "s.yaml:4:13: bone.voxel_mm: found 0; expected a number, 0.01 to 5 (mm)");
  EXPECT_EQ(changed("[10, 10, 6]", "[10, 10, -6]"),
            "s.yaml:7:23: bone.phantom.size_mm: found -6; expected 3 numbers [x, y, z], each 0.5 to 1000 (mm)");
  EXPECT_EQ(changed("enabled: false", "width_px: 99999999999999999999"),
            "s.yaml:15:13: render.width_px: found 99999999999999999999; expected a whole number, 64 to 16384 (px)");
  EXPECT_EQ(changed("  mesh: tool.stl\n", "  mesh: tool.stl\n  shell_resolution: 4097\n"),
            "s.yaml:10:21: tool.shell_resolution: found 4097; expected a whole number, 0 to 4096");
}

TEST_F(BadKey, NotFinite) {
  EXPECT_EQ(changed("voxel_mm: 0.5", "voxel_mm: .nan"),
            "s.yaml:4:13: bone.voxel_mm: found .nan, which is not finite; expected a number, 0.01 to 5 (mm)");
  for (const char* value : {"nan", "NaN", ".inf", "-.Inf", "inf", "1e999", "-1e400"}) {
    EXPECT_THAT(changed("position_mm: [0, 0, 1]", "position_mm: [0, " + std::string(value) + ", 1]"),
                HasSubstr("s.yaml:12:36: motion.keyframes.0.position_mm: found " + std::string(value) +
                          ", which is not finite"));
  }
}

TEST_F(BadKey, WordsOutsideTheirList) {
  EXPECT_EQ(changed("source: phantom", "source: xray"),
            "s.yaml:3:11: bone.source: found the text \"xray\"; expected phantom, ct, mesh or vdb");
  EXPECT_EQ(
      complaint(kValid + "engine:\n  type: fast\n"),
      "s.yaml:17:9: engine.type: found the text \"fast\"; expected auto, exact, bricked, direct, octree or implicit");
  EXPECT_EQ(complaint(kValid + "cutting:\n  erosion: carve\n"),
            "s.yaml:17:12: cutting.erosion: found the text \"carve\"; expected exact, remove or wear");
  EXPECT_EQ(changed("enabled: false", "cameras: [oblique, top]"),
            "s.yaml:15:22: render.cameras: found the text \"top\"; expected a list of one or more of oblique, glenoid, "
            "section or overview");
  EXPECT_EQ(changed("enabled: false", "cameras: [section, section]"),
            "s.yaml:15:22: render.cameras: found section twice; expected a list of one or more of oblique, glenoid, "
            "section or overview, each once");
  EXPECT_THAT(changed("enabled: false", "cameras: []"), HasSubstr("render.cameras: found a list of 0"));
}

TEST_F(BadKey, TextsMustBePrintable) {
  EXPECT_EQ(changed("version: 2", "version: 2\nname: \"a\\nb\""),
            "s.yaml:2:7: name: found the text \"a\\x0ab\"; expected a text without line breaks or control characters");
  EXPECT_EQ(changed("version: 2", "version: 2\nname: ../x"),
            "s.yaml:2:1: name: found \"../x\"; expected a name that a folder can have, without \"/\"");
  EXPECT_EQ(changed("mesh: tool.stl", "mesh: \"\""), "s.yaml:9:9: tool.mesh: found \"\"; expected a path");
}

}  // namespace
}  // namespace reamsim::test
