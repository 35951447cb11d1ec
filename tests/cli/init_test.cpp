// reamsim init: a first scenario from one point of the glenoid, which runs.
#include "tests/cli/cli_fixture.h"
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
  /// The surface of the glenoid phantom, as a run writes it that never meets the bone.
  void write_glenoid_mesh() {
    write("phantom.yaml", with(with(with_bone("  source: phantom\n  side: left\n  voxel_mm: 0.8\n  phantom:\n"
                                              "    shape: glenoid\n"),
                                    "  plunge:\n", "  plunge:\n    entry_mm: [200, 0, 0]\n"),
                               "render:\n", "output:\n  vti: false\nrender:\n"));
    ASSERT_EQ(call({"run", "phantom.yaml", "-o", "phantom"}).status, 0);
    std::filesystem::copy_file(path("phantom/reamed.stl"), path("bone.stl"));
  }
};

TEST_F(InitTest, WritesAScenarioOfAMeshThatRuns) {
  write_glenoid_mesh();
  const ProgramResult made =
      call({"init", "bone.stl", "-o", "my.yaml", "--near=3,-2,4", "--side", "left", "--voxel-mm", "0.8"});
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_THAT(made.out,
              AllOf(HasSubstr("glenoid found: center_mm ["), HasSubstr("wrote my.yaml; next: reamsim check")));
  EXPECT_THAT(read("my.yaml"), AllOf(HasSubstr("near_mm: [3.00, -2.00, 4.00]"), HasSubstr("path: 'bone.stl'"),
                                     HasSubstr("superior: ["), HasSubstr("# Found: center_mm: [")));
  const ProgramResult done = call({"run", "my.yaml", "-o", "out", "--set", "render.enabled=false", "--device", "serial",
                                   "--set", "motion.frame_rate_hz=100"});
  ASSERT_EQ(done.status, 0) << done.err;
  EXPECT_GT(number_after(read("out/summary.json"), "\"removed_mm3\": "), 300);
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
}

TEST_F(InitTest, SeparatesTheHumerusOfAScan) {
  const std::string scan = data_file("shoulder_ct/shoulder_left.nrrd");
  if (!std::filesystem::exists(scan)) GTEST_SKIP() << "no " << scan << "; set REAMSIM_DATA";
  const ProgramResult made = call({"init", scan, "-o", "my.yaml", "--near=129,178,-443", "--voxel-mm", "0.8"});
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_THAT(made.out, HasSubstr("humeral head: sphere of radius 21."));
  EXPECT_THAT(read("my.yaml"), AllOf(HasSubstr("side: left"), HasSubstr("separate: humerus")));
  const ProgramResult checked = call({"check", "my.yaml"});
  EXPECT_EQ(checked.status, 0) << checked.err;
  EXPECT_THAT(checked.out, Not(HasSubstr("# warning: the tool")));
}

}  // namespace
}  // namespace reamsim::test
