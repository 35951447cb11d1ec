// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/render.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include "sim/base/error.h"
#include "tests/render/picture_file.h"
#include "tests/render/results_fixture.h"
#include "tests/support/temp_dir.h"

namespace reamsim {
namespace {

using test::Picture;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

/// What a command of this test's own writes to its standard output.
std::string output_of(const std::string& command) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string out;
  for (int c = 0; pipe && (c = std::fgetc(pipe.get())) != EOF;) out += static_cast<char>(c);
  return out;
}

/// The colour channels of a picture that is shown here, written as test::Picture.
Picture as_seen(const PixelImage& image) {
  return {image.width_px, image.height_px, image.pixels};
}

ForceLog ramp(int rows) {
  ForceLog log;
  for (int i = 0; i < rows; ++i) {
    ForceRow row;
    row.frame = i;
    row.time_s = 0.01 * i;
    row.layer_axial_force_n = 40.0 * i / rows;
    row.layer_spin_torque_nmm = 900 * std::sin(0.02 * i);
    log.rows.push_back(row);
  }
  return log;
}

TEST(FilmLayoutTest, EvenAndWithoutGapOrOverlap) {
  for (const auto& [width, height] : {std::pair{1920, 1080}, {1921, 1081}, {1080, 1920}, {641, 363}, {65, 64}}) {
    const FilmLayout layout = film_layout(width, height);
    EXPECT_EQ(layout.width_px, width / 2 * 2);
    EXPECT_EQ(layout.height_px, height / 2 * 2);
    const double area = layout.bone.width * layout.bone.height + layout.panel.width * layout.panel.height;
    EXPECT_EQ(area, layout.width_px * layout.height_px);
    EXPECT_EQ(layout.panel.width == 0, width < 100);
    EXPECT_EQ(layout.panel.width == layout.width_px, height > width) << "below the bone where the film is upright";
  }
}

TEST(ForcePanelTest, OnlyCurvesCursorAndNumbersMove) {
  const ForceLog log = ramp(500);
  const ForcePanel panel(log, 640, 720, 0.8);
  const Picture early = as_seen(panel.at(log.rows[100]));
  const Picture late = as_seen(panel.at(log.rows[400]));
  const Box& upper = panel.plot(0);
  const Box& lower = panel.plot(1);
  for (int y = 0; y < early.height; ++y) {
    for (int x = 0; x < early.width; ++x) {
      // The cursor's ball may stand out of the plot by its radius.
      const bool beside = x < upper.x - 8 || x > upper.x + upper.width + 8;
      const bool between = (y > upper.y + upper.height + 8 && y < lower.y - 40) || y > lower.y + lower.height + 8;
      if (beside || between) {
        ASSERT_EQ(early.at(x, y), late.at(x, y)) << x << ' ' << y;
      }
    }
  }
}

TEST(ForcePanelTest, TheCursorStandsAtTheTimeAndTheCurveIsStrongUpToIt) {
  const ForceLog log = ramp(500);
  const ForcePanel panel(log, 640, 720, 0.8);
  const Box& box = panel.plot(0);
  for (const std::size_t i : {50U, 250U, 450U}) {
    const Picture seen = as_seen(panel.at(log.rows[i]));
    const double x = panel.x_of(log.rows[i].time_s);
    EXPECT_NEAR(x, box.x + box.width * static_cast<double>(i) / 499, 1e-6);
    const auto dark = [&](double column) {
      int count = 0;
      for (int y = static_cast<int>(box.y) + 2; y < box.y + box.height - 2; ++y) {
        count += seen.at(static_cast<int>(column), y).maxCoeff() < 200 ? 1 : 0;
      }
      return count;
    };
    EXPECT_GT(dark(x), 0.9 * box.height);
    EXPECT_LT(dark(x - 12), 0.2 * box.height);
    EXPECT_LT(dark(x + 12), 0.2 * box.height);
    // The force is a ramp from 0 to the top of the axis, 40 N.
    const auto blue = [&](double fraction) {
      const int column = static_cast<int>(box.x + box.width * fraction);
      const int middle = static_cast<int>(box.y + box.height * (1 - fraction));
      int least_red = 255;
      for (int y = middle - 3; y <= middle + 3; ++y) least_red = std::min(least_red, seen.at(column, y).x());
      return least_red;
    };
    const double now = static_cast<double>(i) / 500;
    EXPECT_LT(blue(now - 0.05), 90) << "strong before the cursor";
    EXPECT_GT(blue(now + 0.05), 140) << "pale after it";
    EXPECT_LT(blue(now + 0.05), 230) << "but there";
  }
}

TEST(ForcePanelTest, APushHasItsFeedRateBelowForceAndTorque) {
  ForceLog log = ramp(500);
  for (ForceRow& row : log.rows) row.push = PushResult{.feed_mm_s = row.frame < 250 ? 5.0 : 1.0};
  const ForcePanel panel(log, 640, 720, 0.8);
  const Box& feed = panel.plot(2);
  EXPECT_GT(feed.y, panel.plot(1).y + panel.plot(1).height);
  EXPECT_LT(feed.y + feed.height, 720);
  EXPECT_EQ(feed.height, panel.plot(0).height);
  const Picture seen = as_seen(panel.at(log.rows.back()));
  const auto green = [&](double time_s) {
    for (int y = static_cast<int>(feed.y); y < feed.y + feed.height; ++y) {
      if (seen.at(static_cast<int>(panel.x_of(time_s)), y).x() < 60) return (y - feed.y) / feed.height;
    }
    return -1.0;
  };
  EXPECT_NEAR(green(1), 0, 0.05) << "5 mm/s, the top of the axis";
  EXPECT_NEAR(green(4), 0.8, 0.05) << "1 mm/s";
}

TEST(ForcePanelTest, ALogOfZerosOrOfOneRowHasAxesToo) {
  ForceLog log = ramp(1);
  EXPECT_EQ(ForcePanel(log, 300, 300, 0.4).at(log.rows[0]).width_px, 300);
  log = ramp(40);
  for (ForceRow& row : log.rows) row.layer_axial_force_n = row.layer_spin_torque_nmm = 0;
  EXPECT_EQ(ForcePanel(log, 300, 300, 0.4).at(log.rows[20]).height_px, 300);
}

class Films : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* path = std::getenv("PATH");
    old_path_ = path == nullptr ? "" : path;
    FixtureOptions options;
    options.voxel_mm = 1;
    options.every = 10;  // seven snapshots
    write_results(dir_.path(), options);
    settings_.width_px = 641;
    settings_.height_px = 361;
    settings_.cameras = {CameraView::oblique};
    settings_.before_after = settings_.contact_sheet = false;
    settings_.film = FilmFormat::mp4;
    settings_.film_rate_hz = 5;
  }
  void TearDown() override { setenv("PATH", old_path_.c_str(), 1); }

  void render(const PictureProgress& progress = nullptr) {
    render_pictures(dir_.path(), {.settings = settings_, .stills = false}, progress);
  }
  [[nodiscard]] std::string file(const std::string& name) const { return dir_.path() + "/" + name; }
  /// codec, width, height, pixel format, rate and the number of frames that can be decoded
  [[nodiscard]] std::string probe(const std::string& name) const {
    return output_of(
        "ffprobe -v error -count_frames -select_streams v:0 -show_entries "
        "stream=codec_name,width,height,pix_fmt,r_frame_rate,nb_read_frames -of csv=p=0 " +
        file(name));
  }
  /// Frame k of a film, decoded.
  [[nodiscard]] Picture frame(const std::string& name, int k) const {
    output_of("ffmpeg -v error -y -i " + file(name) + " -vf \"select=eq(n\\," + std::to_string(k) + ")\" -vframes 1 " +
              file("decoded.png"));
    return test::read_picture(file("decoded.png"));
  }
  /// Puts a program called ffmpeg before the real one.
  void fake_ffmpeg(const std::string& script) const {
    fs::create_directories(file("bin"));
    std::ofstream(file("bin/ffmpeg")) << "#!/bin/sh\n" << script;
    fs::permissions(file("bin/ffmpeg"), fs::perms::owner_all);
    setenv("PATH", (file("bin") + ":" + old_path_).c_str(), 1);
  }
  void expect_failure(const std::string& words) {
    try {
      render();
      ADD_FAILURE() << "no complaint";
    } catch (const RunError& error) {
      EXPECT_THAT(error.what(), HasSubstr(words));
      EXPECT_THAT(error.what(), ::testing::Not(HasSubstr("\n")));
    }
    EXPECT_FALSE(fs::exists(file("reamed.mp4")));
    EXPECT_FALSE(fs::exists(file("reamed.mp4.partial")));
  }

  test::TempDir dir_;
  std::string old_path_;
  RenderSettings settings_;
};

TEST_F(Films, HasAFramePerSnapshotOfEvenSize) {
  int last = 0;
  render([&](int done, int total, const std::string&) {
    EXPECT_EQ(total, 7);
    last = done;
  });
  EXPECT_EQ(last, 7);
  EXPECT_EQ(probe("reamed.mp4"), "h264,640,360,yuv420p,5/1,7\n");
  EXPECT_FALSE(fs::exists(file("reamed.mp4.partial")));
  // The index stands before the pictures, so that a browser can start at once.
  const std::string bytes = test::file_bytes(file("reamed.mp4"));
  EXPECT_LT(bytes.find("moov"), bytes.find("mdat"));
}

TEST_F(Films, FrameKIsSnapshotK) {
  render();
  const FilmLayout layout = film_layout(settings_.width_px, settings_.height_px);
  const ForceLog log = read_force_log(file("forces.csv"));
  const ForcePanel panel(log, static_cast<int>(layout.panel.width), static_cast<int>(layout.panel.height), layout.unit);
  const Box& box = panel.plot(1);
  for (int k = 1; k < 7; ++k) {
    const Picture seen = frame("reamed.mp4", k);
    ASSERT_EQ(seen.width, 640);
    const double time_s = log.at(10 * k, "").time_s;
    // The darkest column of the lower plot is the cursor's.
    int darkest = 0;
    double least = 1e9;
    for (int x = static_cast<int>(layout.panel.x + box.x) - 1; x < layout.panel.x + box.x + box.width + 1; ++x) {
      double sum = 0;
      for (int y = static_cast<int>(box.y); y < box.y + box.height; ++y) sum += seen.at(x, y).sum();
      if (sum < least) darkest = x;
      least = std::min(least, sum);
    }
    EXPECT_NEAR(darkest + 0.5, layout.panel.x + panel.x_of(time_s), 1.5) << k;
  }
}

TEST_F(Films, AnimatedPicturesToo) {
  settings_.film = FilmFormat::apng;
  render();
  EXPECT_THAT(probe("reamed.apng"), HasSubstr("apng,640,360,rgb24"));
  EXPECT_THAT(probe("reamed.apng"), HasSubstr(",7\n"));
  settings_.film = FilmFormat::webp;
  render();
  const std::string bytes = test::file_bytes(file("reamed.webp"));
  EXPECT_EQ(bytes.substr(8, 4), "WEBP");
  int frames = 0;
  for (std::size_t at = 0; (at = bytes.find("ANMF", at)) != std::string::npos; ++at) ++frames;
  EXPECT_GE(frames, 6) << "equal pictures may be shown as one";
  EXPECT_LE(frames, 7);
}

TEST_F(Films, TheTurntableIsFilmedAsWell) {
  settings_.turntable_pictures = 5;
  render();
  EXPECT_EQ(probe("turntable.mp4"), "h264,640,360,yuv420p,5/1,5\n");
}

TEST_F(Films, TheSamePicturesGiveTheSameFilm) {
  render();
  const std::string before = test::file_bytes(file("reamed.mp4"));
  render();
  EXPECT_EQ(test::file_bytes(file("reamed.mp4")), before);
}

TEST_F(Films, WithoutFfmpegTheMessageSaysWhatToInstall) {
  setenv("PATH", file("nothing").c_str(), 1);
  expect_failure("apt-get install ffmpeg");
  EXPECT_THROW(require_film_program(settings_), RunError);
  settings_.film = FilmFormat::none;
  EXPECT_NO_THROW(require_film_program(settings_));
  EXPECT_NO_THROW(render());
}

TEST_F(Films, AnFfmpegThatCannotWriteTheFormatIsSaid) {
  fake_ffmpeg("echo ' V..... mpeg4'\n");
  expect_failure("no encoder libx264");
}

TEST_F(Films, WhatFfmpegSaysIsReported) {
  const std::string knows = "case \"$*\" in *-encoders*) echo ' V....D libx264 H.264'; exit 0;; esac\n";
  fake_ffmpeg(knows + "echo 'No space left on device' >&2\nexit 1\n");
  expect_failure("No space left on device");
  fake_ffmpeg(knows + "cat > /dev/null\nexit 3\n");
  expect_failure("without an error message");
  fake_ffmpeg(knows + "cat > /dev/null\n");
  expect_failure("wrote no file");
}

TEST_F(Films, AnInterruptedFilmLeavesNothing) {
  struct Stop {};
  EXPECT_THROW(render([](int done, int, const std::string&) {
                 if (done == 3) throw Stop();
               }),
               Stop);
  EXPECT_FALSE(fs::exists(file("reamed.mp4")));
  EXPECT_FALSE(fs::exists(file("reamed.mp4.partial")));
}

}  // namespace
}  // namespace reamsim
