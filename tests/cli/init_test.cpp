// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// reamsim init: a first scenario with or without a point on the glenoid, which runs.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <map>

#include "tests/cli/cli_fixture.h"
#include "tests/cli/data_files.h"
#include "tests/support/real_data.h"

namespace reamsim::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class InitTest : public CliTest {
 protected:
  ProgramResult call(const std::vector<std::string>& arguments) const {
    return reamsim({.arguments = arguments, .environment = {}, .folder = "", .interrupt_when = {}});
  }
  /// Bones are kept in the folder of the test.
  std::map<std::string, std::string> kept_bones() const {
    return {{"REAMSIM_CACHE", ""}, {"XDG_CACHE_HOME", path("cache")}};
  }
  /// The surface of the glenoid phantom, as a run writes it that never meets the bone.
  void write_glenoid_mesh() {
    meshes_ = true;
    write("phantom.yaml", with(with(with_bone("  source: phantom\n  side: left\n  voxel_mm: 1.2\n  phantom:\n"
                                              "    shape: glenoid\n"),
                                    "  plunge:\n", "  plunge:\n    entry_mm: [200, 0, 0]\n"),
                               "render:\n", "output:\n  vti: false\nrender:\n"));
    ASSERT_EQ(call({"run", "phantom.yaml", "-o", "phantom"}).status, 0);
    meshes_ = false;
    std::filesystem::copy_file(path("phantom/reamed.stl"), path("bone.stl"));
  }
};

TEST_F(InitTest, WritesAScenarioOfAMeshThatRuns) {
  write_glenoid_mesh();
  const ProgramResult made =
      call({"init", "bone.stl", "-o", "my.yaml", "--near=3,-2,4", "--side", "left", "--voxel-mm", "1.2"});
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_THAT(made.out,
              AllOf(HasSubstr("glenoid found: center_mm ["), HasSubstr("wrote my.yaml; next: reamsim check")));
  EXPECT_THAT(read("my.yaml"), AllOf(HasSubstr("near_mm: [3.00, -2.00, 4.00]"), HasSubstr("path: 'bone.stl'"),
                                     HasSubstr("superior: ["), HasSubstr("# Found: center_mm: [")));
  const ProgramResult done = call({"run", "my.yaml", "-o", "out", "--set", "render.enabled=false", "--device", "serial",
                                   "--set", "motion.frame_rate_hz=50"});
  ASSERT_EQ(done.status, 0) << done.err;
  EXPECT_GT(number_after(read("out/summary.json"), "\"removed_mm3\": "), 300);
}

/// The binary STL of write_glenoid_mesh(), with all lengths multiplied.
std::string scaled_stl(std::string stl, double factor) {
  for (std::size_t facet = 84; facet + 50 <= stl.size(); facet += 50) {
    for (std::size_t at = facet + 12; at < facet + 48; at += 4) {
      float x = 0;
      std::memcpy(&x, stl.data() + at, 4);
      x *= static_cast<float>(factor);
      std::memcpy(stl.data() + at, &x, 4);
    }
  }
  return stl;
}

TEST_F(InitTest, SaysWhichUnitOfAMeshWasFoundOrAssumed) {
  write_glenoid_mesh();
  const std::string mesh = read("bone.stl");
  float least = 1e9F, most = -1e9F;  // along its longest side, x, y or z
  double length_mm = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    least = 1e9F, most = -1e9F;
    for (std::size_t facet = 84; facet + 50 <= mesh.size(); facet += 50) {
      for (std::size_t corner = 1; corner <= 3; ++corner) {
        float x = 0;
        std::memcpy(&x, mesh.data() + facet + 12 * corner + 4 * axis, 4);
        least = std::min(least, x);
        most = std::max(most, x);
      }
    }
    length_mm = std::max(length_mm, double{most} - double{least});
  }
  ASSERT_LT(length_mm, 100) << "a glenoid, not a scapula";
  // A scapula is 150 mm long: the same shape that large, in several units.
  const double to_scapula = 150 / length_mm;
  const auto init = [&](double factor, const std::vector<std::string>& more) {
    write("unit.stl", scaled_stl(mesh, factor));
    std::vector<std::string> arguments{"init", "unit.stl", "-o", "my.yaml", "--side", "left", "--overwrite"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return call(arguments);
  };
  struct Unit {
    double mm;
    std::string scale, name;
  };
  for (const Unit& unit : {Unit{1000, "1000", "metres"}, {10, "10", "centimetres"}, {25.4, "25.4", "inches"}}) {
    const ProgramResult made = init(to_scapula / unit.mm, {"--near=0,0,0", "--voxel-mm", "4"});
    EXPECT_THAT(made.err, HasSubstr("bone.mesh.scale: " + unit.scale + ": the file is in " + unit.name +
                                    "; the mesh is then 150 mm long, as a scapula; if that is wrong, give --scale"));
  }
  // Small enough to be found: its own size.
  ProgramResult made = init(1, {"--near=0,0,0", "--voxel-mm", "1.6"});
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_THAT(made.err, HasSubstr("bone.mesh.scale: 1: mm is assumed; the mesh is then "));
  EXPECT_THAT(read("my.yaml"),
              HasSubstr("scale: 1                  # file units to mm: mm is assumed; the mesh is then "));
  made = init(0.001, {"--scale", "1000", "--near=0,0,0", "--voxel-mm", "1.6"});
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_THAT(made.err, Not(HasSubstr("bone.mesh.scale")));
  EXPECT_THAT(read("my.yaml"), HasSubstr("scale: 1000                  # file units to mm: given by --scale"));
  made = init(0.0001, {});
  EXPECT_EQ(made.status, 2);
  EXPECT_THAT(made.err, AllOf(HasSubstr("bone.mesh.scale: the mesh is "),
                              HasSubstr("in a unit that is unknown; give --scale: ")));
  // A wrong scale, with and without a point: not hours of search in a bone of metres.
  for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--near=0,0,0"}}) {
    std::vector<std::string> arguments{"--scale", "1000"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    made = init(to_scapula, arguments);
    EXPECT_EQ(made.status, 2);
    EXPECT_THAT(made.err, AllOf(HasSubstr("bone.mesh.scale: the mesh is 1.5e+05 mm long, expected 20 to 400 mm"),
                                HasSubstr("give --scale: ")));
  }
}

TEST_F(InitTest, TakesKeysOfTheScenario) {
  write_glenoid_mesh();
  const auto init = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"init",       "bone.stl", "-o",           "my.yaml",
                                       "--voxel-mm", "1.2",      "--near=0,0,0", "--overwrite"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return call(arguments);
  };
  const ProgramResult made =
      init({"--set", "bone.side=left", "--set", "bone.mesh.scale=1", "--set", "bone.mesh.cortical_hu=1200", "--set",
            "bone.mesh.frame=lps", "--set", "tool.spin=resolved", "--set", "engine.device=serial"});
  ASSERT_EQ(made.status, 0) << made.err;
  const std::string text = read("my.yaml");
  for (const char* line : {"\n    cortical_hu: 1200\n", "\n    frame: lps\n", "\n  spin: resolved\n",
                           "\nengine:\n  device: serial\n", "\n  side: left\n"}) {
    EXPECT_THAT(text, HasSubstr(line));
  }
  expect_refused(init({"--side", "left", "--set", "bone.mesh.nix=1"}), 2, {"bone.mesh.nix"});
  expect_refused(init({"--side", "left", "--scale", "1", "--set", "bone.mesh.scale=2"}), 2, {"--scale"});
}

TEST_F(InitTest, FindsTheUnitOfARealScapula) {
  const std::string file = data_file("scapula_mesh/scapula_left.stl");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no " << file << "; set REAMSIM_DATA";
  write("metres.stl", scaled_stl(file_bytes(file), 0.055));  // that of the file gives 153 mm with 55
  const ProgramResult made =
      call({"init", "metres.stl", "-o", "my.yaml", "--side", "left", "--near=-41,11,39", "--voxel-mm", "1.2"});
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_THAT(made.err, HasSubstr("bone.mesh.scale: 1000: the file is in metres; the mesh is then 153 mm long"));
  EXPECT_THAT(read("my.yaml"),
              HasSubstr("scale: 1000                  # file units to mm: the file is in metres; the mesh "
                        "is then 153 mm long, as a scapula"));
}

/// The numbers of "# Found: center_mm: [x, y, z]".
std::array<double, 3> found_center(const std::string& yaml) {
  const auto at = yaml.find("# Found: center_mm: [");
  std::array<double, 3> out{};
  EXPECT_NE(at, std::string::npos) << yaml;
  if (at == std::string::npos) return out;
  EXPECT_EQ(std::sscanf(yaml.c_str() + at, "# Found: center_mm: [%lf, %lf, %lf]", out.data(), &out[1], &out[2]), 3);
  return out;
}

double distance(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

TEST_F(InitTest, SearchesTheGlenoidOfAMesh) {
  write_glenoid_mesh();
  const std::vector<std::string> options{"--side", "left", "--voxel-mm", "1.2", "--quiet"};
  const auto init = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), options.begin(), options.end());
    return call(arguments);
  };
  ASSERT_EQ(init({"init", "bone.stl", "-o", "searched.yaml"}).status, 0);
  ASSERT_EQ(init({"init", "bone.stl", "-o", "near.yaml", "--near=3,-2,4"}).status, 0);
  EXPECT_LE(distance(found_center(read("searched.yaml")), found_center(read("near.yaml"))), 0.3);
}

TEST_F(InitTest, ARunFindsTheGlenoidThatInitSays) {
  write_glenoid_mesh();
  // The written point has two digits behind the point, these have more.
  for (const std::string near : {"3.00499,-2.00499,4.00499", "2.12345,-1.98765,3.54321"}) {
    const ProgramResult made = call(
        {"init", "bone.stl", "-o", "my.yaml", "--side", "left", "--voxel-mm", "1.2", "--near=" + near, "--overwrite"});
    ASSERT_EQ(made.status, 0) << made.err;
    const ProgramResult checked = call({"check", "my.yaml"});
    const auto found = [](const std::string& text) {
      const auto at = text.find("glenoid found: ");
      EXPECT_NE(at, std::string::npos) << text;
      return text.substr(at, text.find(", superior", at) - at);
    };
    EXPECT_EQ(found(made.out), found(checked.out));
  }
}

TEST_F(InitTest, SaysWhyTheSearchForTheGlenoidFoundNone) {
  write_glenoid_mesh();
  // The same bone twice, 200 mm apart: a binary STL has 84 bytes and 50 for each triangle, with three corners.
  const std::string one = read("bone.stl");
  std::string both = one + one.substr(84);
  std::uint32_t count = 0;
  std::memcpy(&count, one.data() + 80, 4);
  for (std::size_t n = 0; n < count; ++n) {
    for (std::size_t corner = 1; corner <= 3; ++corner) {
      char* place = both.data() + one.size() + 50 * n + 12 * corner;
      float x = 0;
      std::memcpy(&x, place, 4);
      x += 200;
      std::memcpy(place, &x, 4);
    }
  }
  count *= 2;
  std::memcpy(both.data() + 80, &count, 4);
  write("two.stl", both);
  const ProgramResult two = call({"init", "two.stl", "-o", "my.yaml", "--side", "left", "--voxel-mm", "1.6"});
  EXPECT_EQ(two.status, 2);
  EXPECT_THAT(two.err, AllOf(HasSubstr("--near: missing, and the search found several faces that may be the glenoid"),
                             HasSubstr("reamsim preview BONE")));
  write("cube.stl", cube_stl(30));
  const ProgramResult none = call({"init", "cube.stl", "-o", "my.yaml", "--side", "left", "--voxel-mm", "1.6"});
  EXPECT_EQ(none.status, 2);
  EXPECT_THAT(none.err, HasSubstr("--near: missing, and the search found no"));
  EXPECT_FALSE(exists("my.yaml"));
}

TEST_F(InitTest, SearchesTheGlenoidOfTheRealBones) {
  struct Case {
    std::string file;
    std::vector<std::string> options;
    std::string near;
  };
  const Case cases[] = {{"shoulder_ct/shoulder_left.nrrd", {}, "--near=129,178,-443"},
                        {"scapula_mesh/scapula_left.stl", {"--side", "left", "--scale", "55"}, "--near=-41,11,39"}};
  for (const Case& bone : cases) {
    const std::string file = data_file(bone.file);
    if (!std::filesystem::exists(file)) GTEST_SKIP() << "no " << file << "; set REAMSIM_DATA";
    std::string said;
    const auto center_of = [&](const std::vector<std::string>& more) {
      std::vector<std::string> arguments{"init", file, "-o", "my.yaml", "--voxel-mm", "1.2", "--overwrite"};
      arguments.insert(arguments.end(), bone.options.begin(), bone.options.end());
      arguments.insert(arguments.end(), more.begin(), more.end());
      const ProgramResult made =
          reamsim({.arguments = arguments, .environment = kept_bones(), .folder = "", .interrupt_when = {}});
      EXPECT_EQ(made.status, 0) << made.err;
      EXPECT_EQ(made.out.find("search for the glenoid") == std::string::npos, !more.empty()) << made.out;
      EXPECT_THAT(made.out, HasSubstr("confidence 0."));
      said = made.out;
      return found_center(read("my.yaml"));
    };
    EXPECT_LE(distance(center_of({}), center_of({bone.near})), 0.5) << bone.file;
    if (!bone.options.empty()) continue;
    EXPECT_THAT(said, HasSubstr("humeral head: sphere of radius 21."));
    EXPECT_THAT(read("my.yaml"), AllOf(HasSubstr("side: left"), HasSubstr("separate: humerus")));
    // With the bone that init has kept.
    const ProgramResult checked = reamsim({.arguments = {"check", "my.yaml", "--set", "engine.device=serial"},
                                           .environment = kept_bones(),
                                           .folder = "",
                                           .interrupt_when = {}});
    EXPECT_EQ(checked.status, 0) << checked.err;
    EXPECT_THAT(checked.out, Not(HasSubstr("# warning: the tool")));
  }
}

TEST_F(InitTest, KeepsWhatItDidNotWrite) {
  write_glenoid_mesh();
  write("my.yaml", "notes: mine\n");
  const ProgramResult kept =
      call({"init", "bone.stl", "-o", "my.yaml", "--near=0,0,0", "--side", "left", "--overwrite"});
  EXPECT_EQ(kept.status, 2);
  EXPECT_THAT(kept.err, HasSubstr("my.yaml"));
  EXPECT_EQ(read("my.yaml"), "notes: mine\n");
}

TEST_F(InitTest, MistakesAreInputErrorsAndWriteNothing) {
  write_glenoid_mesh();
  const auto refuse = [&](const std::vector<std::string>& more, const std::string& message) {
    std::vector<std::string> arguments{"init", "-o", "my.yaml"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramResult refused = call(arguments);
    EXPECT_EQ(refused.status, 2) << message;
    EXPECT_THAT(refused.err, HasSubstr(message));
    EXPECT_FALSE(exists("my.yaml"));
  };
  refuse({"bone.stl", "--near=0,0,0"}, "--side: missing; left or right: a mesh does not say which");
  refuse({"bone.stl", "--near=0,0", "--side", "left"}, "--near");
  refuse({"bone.stl", "--near=90,0,0", "--side", "left"},
         "bone.glenoid.near_mm: (90.0, 0.0, 0.0): no surface of the bone within 15 mm");
  refuse({"none.stl", "--near=0,0,0", "--side", "left"}, "none.stl");
  refuse({"bone.stl", "--near=0,0,0", "--side", "left", "--tool", "none.stl"}, "none.stl");
  refuse({"bone.stl", "--near=0,0,0", "--side", "left", "--set", "motion.plunge.depth_mm=-5"},
         "reamsim: error: motion.plunge.depth_mm: found -5");
  EXPECT_FALSE(exists("my.yaml.tmp"));
}

TEST_F(InitTest, AScanOfTheOtherSideNamesTheSide) {
  const std::string scan = data_file("shoulder_ct/shoulder_left.nrrd");
  if (!std::filesystem::exists(scan)) GTEST_SKIP() << "no " << scan << "; set REAMSIM_DATA";
  const ProgramResult refused = call({"init", scan, "-o", "my.yaml", "--side", "right", "--voxel-mm", "1.6"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.err, HasSubstr("the search found a glenoid of the other side only: check --side"));
}

}  // namespace
}  // namespace reamsim::test
