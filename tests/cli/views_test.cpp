// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <map>

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

/// A run of three small pictures.
const std::string kDrawn = with(kSmall, "  enabled: false\n",
                                "  enabled: true\n  width_px: 96\n  height_px: 72\n  every_frames: 40\n"
                                "  cameras: [oblique, section]\n  before_after: false\n  contact_sheet: false\n");

class ViewsOfARun : public CliTest {
 protected:
  ProgramResult render(const std::vector<std::string>& more) const {
    ProgramCall call{.arguments = {"render", "out"}, .environment = {}, .folder = "", .interrupt_when = {}};
    call.arguments.insert(call.arguments.end(), more.begin(), more.end());
    return reamsim(call);
  }
  /// The program was refused with these words, and the results are still there.
  void expect_complaint(const ProgramResult& result, const char* words) const {
    EXPECT_EQ(result.status, 2) << result.err;
    EXPECT_THAT(result.err, HasSubstr(words));
    EXPECT_TRUE(exists("out/forces.csv"));
  }
};

TEST_F(ViewsOfARun, ACameraDrawnAgainKeepsTheNamesOfItsFiles) {
  expect_done(run(kDrawn));
  const std::string oblique = read("out/reamed.png");
  const std::string section = read("out/reamed_section.png");
  std::filesystem::remove(path("out/reamed_section.png"));
  EXPECT_EQ(render({"--camera", "section"}).status, 0);
  EXPECT_EQ(read("out/reamed.png"), oblique);
  EXPECT_EQ(read("out/reamed_section.png"), section);
}

TEST_F(ViewsOfARun, ARunOfOneFrameHasItsPictures) {
  const std::size_t plunge = kDrawn.find("  plunge:\n");
  const std::string moved = kDrawn.substr(0, plunge) +
                            "  keyframes:\n"
                            "    - {time_s: 0, position_mm: [0, 0, -1], axis: [0, 0, 1], spin_rpm: 250}\n"
                            "    - {time_s: 0.5, position_mm: [0, 0, -1.2], axis: [0, 0, 1], spin_rpm: 250}\n" +
                            kDrawn.substr(kDrawn.find("render:\n"));
  expect_done(run(with(moved, "frame_rate_hz: 100", "frame_rate_hz: 1")));
  EXPECT_TRUE(exists("out/frames/000000.png"));
  EXPECT_TRUE(exists("out/reamed.png"));
}

/// Every file of a folder, by its path in it, with its bytes.
std::map<std::string, std::string> files_of(const std::string& dir) {
  std::map<std::string, std::string> out;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(dir)) {
    if (!entry.is_regular_file()) continue;
    out[std::filesystem::relative(entry.path(), dir).string()] = file_bytes(entry.path().string());
  }
  return out;
}

// The run draws from what it holds, the later one from the folder. The tool starts in the bone, and the last run's bone
// has been reamed before.
TEST_F(ViewsOfARun, DrawnAgainFromTheFolderIsTheSameToTheByte) {
  plots_ = true;
  const std::string phantom =
      "  source: phantom\n  voxel_mm: 0.5\n  phantom:\n    shape: half_space\n    size_mm: [10, 10, 6]\n";
  const std::string motion = "motion:\n  frame: glenoid\n";
  const std::string moved = with(with(kDrawn, "motion:\n", motion), "  plunge:\n",
                                 "  plunge:\n    entry_mm: [0, 0, 0]\n    axis: [0, 0, -1]\n");
  const std::string glenoid =
      with(moved, phantom, "  source: phantom\n  side: left\n  voxel_mm: 1.2\n  phantom:\n    shape: glenoid\n");
  const std::string twice =
      with(with(kDrawn, phantom, "  source: vdb\n  vdb: {path: first.vdb}\n"), "depth_mm: 1\n", "depth_mm: 2\n");
  const std::string remove = with(glenoid, "engine:\n", "cutting:\n  erosion: remove\nengine:\n");
  expect_done(run(kSmall));
  std::filesystem::rename(path("out/reamed.vdb"), path("first.vdb"));
  std::filesystem::remove_all(path("out"));
  for (const std::string& scenario : {glenoid, remove, twice}) {
    expect_done(run(scenario, {"--set", "render.contact_sheet=true", "--set", "render.before_after=true"}));
    const auto before = files_of(path("out"));
    for (const char* name : {"reamed.png", "reamed_section.png", "before_after.png", "contact_sheet.png", "reamed.glb",
                             "reamed.stl", "depth_map.png", "report.html", "plots/removed_density.csv"}) {
      ASSERT_TRUE(before.contains(name)) << name;
      std::filesystem::remove(path("out/" + std::string(name)));
    }
    EXPECT_EQ(render({}).status, 0);
    const auto again = files_of(path("out"));
    ASSERT_EQ(again.size(), before.size());
    for (const auto& [name, bytes] : before) {
      if (name.ends_with(".pdf")) continue;  // gnuplot writes the time into it
      EXPECT_TRUE(again.contains(name) && again.at(name) == bytes) << name;
    }
    std::filesystem::remove_all(path("out"));
  }
}

TEST_F(ViewsOfARun, CamerasInBracesOfTheRunAndUnknown) {
  expect_done(run(kDrawn, {"--set", "render.user_cameras=[{name: mine, position_mm: [0, -40, 30]}]"}));
  EXPECT_TRUE(exists("out/reamed_mine.png"));
  std::filesystem::remove(path("out/reamed_mine.png"));
  EXPECT_EQ(render({"--only", "pictures", "--camera", "mine", "--camera",
                    "{name: other, position_mm: [0, 0, 50], up: [0, 1, 0], projection: orthographic, width_mm: 20}"})
                .status,
            0);
  EXPECT_TRUE(exists("out/reamed_mine.png"));
  EXPECT_TRUE(exists("out/reamed_other.png"));
  expect_complaint(render({"--camera", "theirs"}),
                   "expected glenoid, oblique, section, overview, mine, or a camera in");
  expect_complaint(render({"--camera", "mine", "--camera", "mine"}), "found mine twice");
  expect_complaint(render({"--camera", "{name: other}"}), "--camera {name: other}: position_mm: missing");
  expect_complaint(render({"--camera", "{name: other, position_mm: [0, 0, 5], fov_deg: 500}"}),
                   "}: fov_deg: found 500");
  expect_complaint(render({"--camera", "{name: other, position_mm: ["}), "--camera {name: other, position_mm: [: YAML");
  expect_complaint(render({"--only", "posters"}), "posters");
}

TEST_F(ViewsOfARun, APictureWithoutBoneIsWarnedOf) {
  expect_done(run(kDrawn));
  const auto warned = [&](const std::string& camera) {
    const ProgramResult done = render({"--only", "pictures", "--camera", camera});
    EXPECT_EQ(done.status, 0);
    return done.err.find("looks empty") != std::string::npos;
  };
  EXPECT_FALSE(warned("{name: outside, position_mm: [30, 0, 40]}"));
  EXPECT_TRUE(warned("{name: away, position_mm: [0, 0, 40], target_mm: [0, 0, 80]}"));
  EXPECT_TRUE(warned("{name: inside, position_mm: [3, 0, -4], target_mm: [9, 0, -4]}"));
}

// Of a run with two states.
TEST_F(ViewsOfARun, ARefusedOptionLeavesEveryFileAsItIs) {
  expect_done(run(kDrawn));
  const auto before = files_of(path("out"));
  expect_complaint(render({"--camera", "{name: at, frame: glenoid, position_mm: [0, 0, 0]}"}),
                   "the camera is at its target");
  expect_complaint(render({"--film"}), "kept 2 states: a film of them would last 0.08 s");
  expect_complaint(render({"--only", "film"}), "--set render.film=mp4");
  expect_complaint(render({"--only", "film", "--set", "render.film_rate_hz=3"}), "--film-rate 1");
  EXPECT_EQ(files_of(path("out")), before);
}

// As README says: no --only, so that the report is written too, which shows the cameras of the run.
TEST_F(ViewsOfARun, AllOutputsOfADescribedCameraAlone) {
  plots_ = true;
  expect_done(run(kDrawn));
  std::filesystem::remove(path("out/report.html"));
  EXPECT_EQ(render({"--camera", "{name: rim, position_mm: [60, 35, 70]}"}).status, 0);
  EXPECT_TRUE(exists("out/reamed_rim.png"));
  EXPECT_THAT(read("out/report.html"), HasSubstr("\"name\":\"oblique\""));
  EXPECT_THAT(read("out/plots/forces_depth.pdf"), StartsWith("%PDF"));
  EXPECT_THAT(read("out/plots/forces_depth.svg"), HasSubstr("width=\"321\""))
      << "a column of 85 mm, in pixels of 1/96 inch";
}

TEST_F(ViewsOfARun, OnlyWhatIsNamedIsMadeAgain) {
  expect_done(run(kSmall));
  const auto turntable = {"--only", "turntable", "--turntable", "4", "--width", "96", "--height", "72"};
  EXPECT_EQ(render({turntable.begin(), turntable.end()}).status, 0);
  EXPECT_TRUE(exists("out/turntable/003.png"));
  EXPECT_EQ(
      render({"--only", "before_after", "--only", "turntable", "--turntable", "2", "--width", "160", "--height", "120"})
          .status,
      0);
  EXPECT_TRUE(exists("out/before_after_section.png"));
  EXPECT_TRUE(exists("out/turntable/001.png"));
  EXPECT_FALSE(exists("out/turntable/002.png")) << "of the longer turntable before";
  EXPECT_FALSE(exists("out/turntable/003.png"));
  EXPECT_FALSE(exists("out/reamed.png"));
  EXPECT_FALSE(exists("out/contact_sheet.png"));
}

TEST_F(ViewsOfARun, RenderKeysAreSetAndNoOthers) {
  expect_done(run(kDrawn));
  const std::string plain = read("out/reamed.png");
  EXPECT_EQ(render({"--only", "pictures", "--set", "render.background=white"}).status, 0);
  EXPECT_NE(read("out/reamed.png"), plain);
  EXPECT_EQ(render({"--only", "pictures"}).status, 0);
  EXPECT_EQ(read("out/reamed.png"), plain);
  expect_complaint(render({"--set", "render.background=green"}),
                   "render.background: found the text \"green\"; expected studio, white or transparent");
  expect_complaint(render({"--set", "render.supersampling=9"}), "render.supersampling: found 9");
  expect_complaint(render({"--set", "bone.voxel_mm=1"}), "expected render.KEY=VALUE");
}

TEST_F(ViewsOfARun, AFilmLeavesTheForcesAsTheyAre) {
  expect_done(run(kDrawn, {"--set", "render.enabled=false"}));
  const std::string forces = read("out/forces.csv");
  std::filesystem::remove_all(path("out"));
  expect_done(
      run(kDrawn, {"--set", "render.film=mp4", "--set", "render.every_frames=7", "--set", "render.cameras=[oblique]"}));
  EXPECT_TRUE(exists("out/reamed.mp4"));
  EXPECT_EQ(read("out/forces.csv"), forces);
  std::filesystem::remove(path("out/reamed.mp4"));
  EXPECT_EQ(render({"--only", "film", "--film=webp", "--film-rate", "4"}).status, 0);
  EXPECT_TRUE(exists("out/reamed.webp"));
}

TEST_F(ViewsOfARun, WithoutFfmpegARunThatWantsAFilmDoesNotBegin) {
  write("s.yaml", with(kDrawn, "  enabled: true\n", "  enabled: true\n  film: mp4\n"));
  const std::map<std::string, std::string> bare{{"PATH", dir_}};
  expect_refused(
      reamsim({.arguments = {"run", "s.yaml", "-o", "out"}, .environment = bare, .folder = "", .interrupt_when = {}}),
      1, {"ffmpeg", "apt-get install"});
  const ProgramResult check =
      reamsim({.arguments = {"check", "s.yaml"}, .environment = bare, .folder = "", .interrupt_when = {}});
  EXPECT_EQ(check.status, 0);
  EXPECT_THAT(check.err, HasSubstr("warning: a film needs ffmpeg"));
}

}  // namespace
}  // namespace reamsim::test
