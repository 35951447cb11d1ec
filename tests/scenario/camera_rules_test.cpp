// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>

#include "tests/scenario/scenario_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

/// The user's cameras of a scenario, and what the parser says of them.
class CameraRules : public ScenarioTest {
 protected:
  /// kValid with this camera, whose keys stand in line 17 from column 8 on.
  static std::string with_camera(const std::string& keys) { return kValid + "  user_cameras:\n    - {" + keys + "}\n"; }
  std::string camera(const std::string& keys) const { return complaint(with_camera(keys)); }
};

TEST_F(CameraRules, NameAndPositionAreEnough) {
  const Scenario s = parse(with_camera("name: rim, position_mm: [10, 20, 30]"));
  ASSERT_EQ(s.render.user_cameras.size(), 1U);
  const UserCamera& camera = s.render.user_cameras[0];
  EXPECT_EQ(camera.name, "rim");
  EXPECT_EQ(camera.position_mm, Vec3(10, 20, 30));
  EXPECT_EQ(camera.projection, Projection::perspective);
  EXPECT_EQ(camera.fov_deg, 30);
  EXPECT_FALSE(camera.target_mm || camera.up);
}

TEST_F(CameraRules, TheResolvedTextGivesThemAgain) {
  const std::string keys = "name: a, position_mm: [1, 2, 3], up: [0, 1, 0], target_mm: [0, 0, 0.5], frame: glenoid";
  const std::string once = to_yaml(parse(with_camera(keys) + "    - {name: b, position_mm: [1, 2, 3], projection: "
                                                             "orthographic, width_mm: 12.5}\n"));
  EXPECT_EQ(to_yaml(parse(once)), once);
  EXPECT_THAT(once, HasSubstr("  user_cameras:\n    - name: a\n      frame: glenoid\n"));
  EXPECT_THAT(once, HasSubstr("      projection: orthographic\n      width_mm: 12.5\n"));
}

TEST_F(CameraRules, KeysOutOfRange) {
  EXPECT_EQ(camera("name: a"),
            "s.yaml:17:7: render.user_cameras.0.position_mm: missing; expected this key: Camera position");
  EXPECT_EQ(camera("name: a, position_mm: [1, 2, 3], fov_deg: 121"),
            "s.yaml:17:50: render.user_cameras.0.fov_deg: found 121; expected a number, 1 to 120 (°)");
  EXPECT_EQ(camera("name: a, position_mm: [1, 2, 3], width_mm: 5"),
            "s.yaml:17:41: render.user_cameras.0.width_mm: does not apply: projection is perspective; expected it with "
            "projection: orthographic only");
  EXPECT_EQ(camera("name: a, position_mm: [1, 2, 3], up: [0, 0, 0]"),
            "s.yaml:17:45: render.user_cameras.0.up: found a direction of length 0; expected 3 numbers [x, y, z], not "
            "all zero, each -1000 to 1000");
}

TEST_F(CameraRules, AViewThatCannotBe) {
  EXPECT_EQ(camera("name: a, position_mm: [1, 2, 3], target_mm: [1, 2, 3]"),
            "s.yaml:17:17: render.user_cameras.0.position_mm: found target_mm; expected a place at least 0.1 mm from "
            "it");
  EXPECT_EQ(camera("name: a, position_mm: [0, 0, 9], target_mm: [0, 0, 0], up: [0, 0.001, -1]"),
            "s.yaml:17:63: render.user_cameras.0.up: found the direction from position_mm to target_mm; expected a "
            "direction across it");
}

TEST_F(CameraRules, NamesTellFilesApart) {
  for (const char* name : {"Rim", "a/b", "..", "\"a b\"", "é"}) {
    EXPECT_THAT(camera(std::string("name: ") + name + ", position_mm: [1, 2, 3]"),
                HasSubstr("expected up to 40 lower-case letters, digits, _ and -"))
        << name;
  }
  EXPECT_EQ(camera("name: section, position_mm: [1, 2, 3]"),
            "s.yaml:17:8: render.user_cameras.0.name: found a camera name that is used twice; expected another name");
  EXPECT_EQ(complaint(with_camera("name: a, position_mm: [1, 2, 3]") + "    - {name: a, position_mm: [3, 2, 1]}\n"),
            "s.yaml:18:8: render.user_cameras.1.name: found a twice; expected another name");
}

TEST_F(CameraRules, AGlenoidFrameIsNeededWhereACameraStandsInIt) {
  const std::string mesh = with(with_camera("name: a, position_mm: [1, 2, 3], frame: glenoid"),
                                "  source: phantom\n  voxel_mm: 0.5\n  phantom:\n    shape: half_space\n    size_mm: "
                                "[10, 10, 6]\n",
                                "  source: mesh\n  mesh: {path: tool.stl}\n");
  EXPECT_THAT(complaint(mesh), HasSubstr("render.user_cameras.0.frame: frame is glenoid but bone.glenoid is missing"));
}

TEST_F(CameraRules, ResultsAreHeldToThemToo) {
  write("r.yaml", "version: 2\ntool: {mesh: gone.stl}\n");
  try {
    parse_result_settings(path("r.yaml"), {"render.user_cameras=[{name: oblique, position_mm: [1, 2, 3]}]"});
    ADD_FAILURE() << "no complaint";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("a camera name that is used twice"));
  }
}

}  // namespace
}  // namespace reamsim::test
