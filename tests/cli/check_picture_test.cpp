// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The picture of `reamsim check --picture`: what it shows, and what it refuses.
#include "tests/cli/cli_fixture.h"
#include "tests/render/picture_file.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

const std::string kOnFace =
    with(with_bone("  source: phantom\n  side: left\n  voxel_mm: 0.8\n  phantom: {shape: glenoid}\n"), "motion:\n",
         "motion:\n  frame: glenoid\n");

/// Pixels of the left, middle and right view by what they show.
struct Seen {
  int bone = 0;
  int steel = 0;  ///< grey, neither background nor white
  int path = 0;
  int reamed = 0;  ///< green, a colour of the depth only
};

Seen seen_in(const Picture& picture, int view) {
  Seen out;
  for (int y = 68; y < picture.height; ++y) {
    for (int x = view * picture.width / 3; x < (view + 1) * picture.width / 3; ++x) {
      const Eigen::Vector3i rgb = picture.at(x, y);
      out.reamed += rgb.y() > rgb.x() + 25 && rgb.y() > rgb.z() + 25 ? 1 : 0;
      out.bone += looks_like_bone(rgb) ? 1 : 0;
      out.path += (rgb - Eigen::Vector3i(214, 94, 0)).cwiseAbs().maxCoeff() < 12 ? 1 : 0;
      out.steel += rgb.maxCoeff() - rgb.minCoeff() < 20 && rgb.maxCoeff() < 170 && rgb.minCoeff() > 60 ? 1 : 0;
    }
  }
  return out;
}

class CheckPicture : public CliTest {
 protected:
  ProgramResult check(const std::string& yaml, const std::vector<std::string>& more) const {
    write("s.yaml", yaml);
    ProgramCall call{.arguments = {"check", "s.yaml"}, .environment = {}, .folder = "", .interrupt_when = {}};
    call.arguments.insert(call.arguments.end(), more.begin(), more.end());
    return reamsim(call);
  }
  void expect_bone_and_tool(const Picture& picture) const {
    ASSERT_EQ(picture.width, 1912);
    const Seen start = seen_in(picture, 0);
    EXPECT_GT(start.bone, 5000);
    EXPECT_GT(start.steel, 500);
    for (int view = 0; view < 3; ++view) EXPECT_GT(seen_in(picture, view).path, 50) << view;
  }
};

TEST_F(CheckPicture, ShowsBoneToolAndPath) {
  const ProgramResult result = check(kOnFace, {"--picture", "p.png"});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("# picture: p.png"));
  const Picture picture = read_picture(path("p.png"));
  expect_bone_and_tool(picture);
  EXPECT_GT(seen_in(picture, 1).reamed, 5000) << "en face: what the tool sweeps is removed";
  EXPECT_EQ(seen_in(picture, 0).reamed, 0) << "not yet at the start";
  EXPECT_FALSE(exists("p.png.tmp"));
  EXPECT_FALSE(exists("out"));
  const std::string first = read("p.png");
  EXPECT_EQ(check(kOnFace, {"--picture", "p.png", "--overwrite"}).status, 0);
  EXPECT_EQ(read("p.png"), first) << "the same picture of the same scenario";
}

TEST_F(CheckPicture, OfAToolThatNeverTouchesTheBone) {
  const ProgramResult result = check(kOnFace, {"--set", "motion.plunge.entry_mm=[60, 0, 0]", "--picture", "p.png"});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("never touches the bone"));
  const Picture picture = read_picture(path("p.png"));
  expect_bone_and_tool(picture);
  for (int view = 0; view < 3; ++view) EXPECT_GT(seen_in(picture, view).steel, 500) << view;
}

TEST_F(CheckPicture, OfAFrameThatIsRefused) {
  const std::string yaml =
      with(kSmall, "    size_mm: [10, 10, 6]\n",
           "    size_mm: [10, 10, 6]\n  side: left\n  glenoid:\n    center_mm: [0, 0, 0]\n    normal: [0, 0, -1]\n"
           "    superior: [0, 1, 0]\n");
  const ProgramResult result = check(yaml, {"--picture", "p.png"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.err, HasSubstr("bone.glenoid.normal: the glenoid's normal points into the bone"));
  EXPECT_EQ(read_picture(path("p.png")).width, 1912) << "it shows the mistake";
}

TEST_F(CheckPicture, RefusesOtherFilesBeforeAnyWork) {
  write("foreign.png", "a picture of someone else");
  expect_refused(check(kOnFace, {"--picture", "foreign.png"}), 2, {"foreign.png", "exists", "--overwrite"});
  expect_refused(check(kOnFace, {"--picture", "foreign.png", "--overwrite"}), 2,
                 {"foreign.png", "not a file that reamsim"});
  EXPECT_EQ(read("foreign.png"), "a picture of someone else");
  expect_refused(check(kOnFace, {"--picture", "p.jpg"}), 2, {"p.jpg", ".png"});
  expect_refused(check(kOnFace, {"--picture", "nix/p.png"}), 2, {"nix/p.png", "there is no folder"});
  expect_refused(check(with(kOnFace, "voxel_mm: 0.8", "voxel_mm: thick"), {"--picture", "p.png"}), 2,
                 {"s.yaml:", "voxel_mm"});
  EXPECT_FALSE(exists("p.png"));
}

}  // namespace
}  // namespace reamsim::test
