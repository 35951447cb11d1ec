// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "render/pictures/figures.h"
#include "render/pictures/run_view.h"
#include "render/render.h"
#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/scenario/scenario.h"
#include "tests/render/picture_file.h"
#include "tests/render/results_fixture.h"
#include "tests/support/temp_dir.h"

namespace reamsim {
namespace {

using test::Picture;
namespace fs = std::filesystem;

constexpr int kViewWidth = 640;
constexpr int kViewHeight = 360;

RenderSettings plain_settings() {
  RenderSettings settings;
  settings.width_px = kViewWidth;
  settings.height_px = kViewHeight;
  settings.cameras = {CameraView::glenoid};
  settings.before_after = false;
  settings.contact_sheet = false;
  return settings;
}

/// Looks at the glenoid's face from 100 mm, superior up.
UserCamera own_camera() {
  UserCamera camera;
  camera.name = "own";
  camera.frame = PoseFrame::glenoid;
  camera.position_mm = Vec3(0, 0, 100);
  camera.target_mm = Vec3::Zero();
  camera.up = Vec3::UnitY();
  camera.fov_deg = 30;
  return camera;
}

/// What the background is made of: light and a little blue.
bool is_studio(const Eigen::Vector3i& color) {
  return color.z() >= color.y() && color.y() >= color.x() && color.x() > 190 && color.z() - color.x() < 20;
}

class Views : public ::testing::Test {
 protected:
  void SetUp() override {
    FixtureOptions options;
    options.voxel_mm = 1;
    options.every = 10;  // seven snapshots
    truth_ = write_results(dir_.path(), options);
  }
  void render(PictureOptions options = {}) {
    options.settings = settings_;
    render_pictures(dir_.path(), options);
  }
  [[nodiscard]] Picture picture(const std::string& name) const { return test::read_picture(dir_.path() + "/" + name); }

  test::TempDir dir_;
  FixtureTruth truth_;
  RenderSettings settings_ = plain_settings();
};

TEST(DepthText, OfAReamerThatIsDrawnBackThereIsNone) {
  EXPECT_EQ(depth_text(0), "0.00 mm");
  EXPECT_EQ(depth_text(3.984), "3.98 mm");
  EXPECT_EQ(depth_text(-8.02), "lifted");
}

TEST_F(Views, BeforeAndAfterAreSeenByTheSameCamera) {
  settings_.before_after = true;
  render({.stills = false});
  EXPECT_FALSE(fs::exists(dir_.path() + "/reamed.png"));
  const Picture both = picture("before_after.png");
  ASSERT_EQ(both.width, kViewWidth);
  ASSERT_EQ(both.height, kViewHeight);

  const RunView view(dir_.path(), settings_);
  const Camera camera = half_camera(view, "glenoid");
  const int half = camera.width_px;
  const int right_px = page_layout(kViewWidth, kViewHeight).view_width_px - half;
  const int head = kViewHeight - camera.height_px;
  const auto colors_at = [&](const Vec3& glenoid_mm) {
    const Vec2 at = camera.pixel(truth_.bone_from_glenoid * glenoid_mm);
    const int x = static_cast<int>(at.x());
    const int y = static_cast<int>(at.y());
    EXPECT_TRUE(x >= 0 && x < half);
    return std::pair(both.at(x, head + y), both.at(right_px + x, head + y));
  };
  const auto [whole, reamed] = colors_at(Vec3(4, -4, -2));
  EXPECT_TRUE(test::looks_like_bone(whole)) << whole.transpose();
  EXPECT_FALSE(test::looks_like_bone(reamed)) << reamed.transpose();
  for (const Vec3& untouched : {Vec3(0, -16.5, 0), Vec3(0, 16, 0)}) {
    const auto [left, right] = colors_at(untouched);
    EXPECT_TRUE(test::looks_like_bone(left));
    EXPECT_LE((left - right).cwiseAbs().maxCoeff(), 3);
  }
  EXPECT_GT(both.at(half, kViewHeight / 2).minCoeff(), 250) << "the halves are parted";
}

TEST_F(Views, EachCameraHasItsOwnBeforeAndAfter) {
  settings_.before_after = true;
  settings_.cameras = {CameraView::oblique, CameraView::section};
  settings_.user_cameras = {own_camera()};
  render({.stills = false});
  for (const char* name : {"before_after.png", "before_after_section.png", "before_after_own.png"}) {
    EXPECT_EQ(picture(name).width, kViewWidth) << name;
  }
}

TEST_F(Views, AUsersCameraSeesWhatAPinholeSees) {
  settings_.user_cameras = {own_camera()};
  render();
  EXPECT_FALSE(fs::exists(dir_.path() + "/reamed_glenoid.png")) << "the first camera's files have no suffix";
  EXPECT_TRUE(fs::exists(dir_.path() + "/frames/000030_own.png"));
  const Picture seen = picture("reamed_own.png");
  ASSERT_EQ(seen.width, kViewWidth);
  const int view_width = page_layout(kViewWidth, kViewHeight).view_width_px;
  const double focal_px = 0.5 * kViewHeight / std::tan(15 * 3.14159265358979 / 180);
  const auto color_at = [&](const Vec3& p) {
    return seen.at(static_cast<int>(0.5 * view_width + focal_px * p.x() / (100 - p.z())),
                   static_cast<int>(0.5 * kViewHeight - focal_px * p.y() / (100 - p.z())));
  };
  // The bump on the superior rim is a ball of 3 mm about (0, 15, 0.5).
  EXPECT_TRUE(test::looks_like_bone(color_at(Vec3(0, 15, 3))));
  EXPECT_TRUE(test::looks_like_bone(color_at(Vec3(0, 17.2, 0.5))));
  EXPECT_TRUE(is_studio(color_at(Vec3(0, 19.2, 0.5))));
  EXPECT_TRUE(is_studio(color_at(Vec3(0, -19.5, -16)))) << "there is no bump on the inferior rim";
}

TEST_F(Views, FilesKeepTheirNamesWhenACameraIsDrawnAlone) {
  settings_.cameras = {CameraView::section};
  render({.camera_without_suffix = "oblique"});
  EXPECT_TRUE(fs::exists(dir_.path() + "/reamed_section.png"));
  EXPECT_FALSE(fs::exists(dir_.path() + "/reamed.png"));
}

TEST(ContactSheetTest, TwentyFramesAtMostFirstAndLastAmongThem) {
  const auto count_to = [](std::int64_t last) {
    std::vector<std::int64_t> frames;
    for (std::int64_t i = 0; i <= last; ++i) frames.push_back(7 * i);
    return frames;
  };
  EXPECT_EQ(evenly_among(count_to(0), 20), count_to(0));
  EXPECT_EQ(evenly_among(count_to(10), 20), count_to(10));
  EXPECT_EQ(evenly_among(count_to(19), 20), count_to(19));
  const auto many = evenly_among(count_to(150), 20);
  ASSERT_EQ(many.size(), 20U);
  EXPECT_EQ(many.front(), 0);
  EXPECT_EQ(many.back(), 7 * 150);
  for (std::size_t i = 1; i < many.size(); ++i) {
    EXPECT_NEAR(static_cast<double>(many[i] - many[i - 1]), 7 * 150 / 19.0, 7);
  }
}

TEST(PictureFrames, AreSpreadOverTheContact) {
  const RenderSettings settings;
  const FrameSpans contact{{1000, 1800}};
  EXPECT_EQ(picture_frames(settings, 3000, contact),
            (std::vector<std::int64_t>{0, 1000, 1160, 1320, 1480, 1640, 1800, 3000}));
  // As many of a run that begins or ends in contact, or is never out of it.
  EXPECT_EQ(picture_frames(settings, 3500, {{0, 3500}}), picture_frames(settings, 3500, {}));
  EXPECT_EQ(picture_frames(settings, 3000, {{0, 900}}).size(), 8U);
  EXPECT_EQ(picture_frames(settings, 3000, {{900, 3000}}).size(), 8U);
  EXPECT_EQ(picture_frames(settings, 3000, {{900, 902}}), (std::vector<std::int64_t>{0, 900, 901, 902, 3000}));
  EXPECT_EQ(picture_frames(settings, 0, {{0, 0}}), std::vector<std::int64_t>{0});
}

TEST(PictureFrames, AreNotBetweenPasses) {
  const FrameSpans passes{{1000, 1200}, {2000, 2300}, {2900, 3190}};
  const std::vector<std::int64_t> frames = picture_frames(RenderSettings(), 3500, passes);
  // Every 99th of the 793 frames of the passes.
  EXPECT_EQ(frames, (std::vector<std::int64_t>{0, 1000, 1099, 1198, 2096, 2195, 2294, 2992, 3091, 3190, 3500}));
  EXPECT_EQ(in_contact(frames, passes).size(), 9U);
  EXPECT_EQ(in_contact({0, 1050, 1500, 2100, 2600, 3000, 3500}, passes), (std::vector<std::int64_t>{1050, 2100, 3000}));
}

TEST(PictureFrames, FollowANumberOfTheUserAndAFilm) {
  RenderSettings settings;
  const FrameSpans contact{{1000, 1800}};
  settings.every_frames = 1500;
  EXPECT_EQ(picture_frames(settings, 3000, contact), (std::vector<std::int64_t>{0, 1500, 3000}));
  EXPECT_EQ(still_frames({0, 1500, 3000}, settings, contact).size(), 3U);
  settings.every_frames = 0;
  settings.film = FilmFormat::mp4;
  const std::vector<std::int64_t> film = picture_frames(settings, 3000, contact);
  EXPECT_EQ(film.size(), 151U);
  EXPECT_EQ(film.at(1), 20) << "evenly spaced along the run";
  const std::vector<std::int64_t> stills = still_frames(film, settings, contact);
  ASSERT_EQ(stills.size(), 8U);
  EXPECT_EQ(stills.front(), 0);
  EXPECT_EQ(stills.back(), 3000);
  EXPECT_NEAR(static_cast<double>(stills.at(1)), 1000, 60);
  EXPECT_NEAR(static_cast<double>(stills.at(6)), 1800, 60);
}

TEST(PictureFrames, OnTheContactSheetAreThoseInContact) {
  EXPECT_EQ(in_contact({0, 990, 1000, 1400, 1800, 3000}, {{1000, 1800}}),
            (std::vector<std::int64_t>{990, 1000, 1400, 1800}));
  EXPECT_EQ(in_contact({0, 1500, 3000}, {{1000, 1800}}), (std::vector<std::int64_t>{0, 1500, 3000}))
      << "one alone is no sheet";
  EXPECT_EQ(in_contact({0, 1500, 3000}, {}).size(), 3U);
}

TEST(ContactSheetTest, EveryCellHasItsPlaceOnThePage) {
  for (const auto& [width, height] : {std::pair{1920, 1080}, {1080, 1920}, {640, 360}, {64, 64}}) {
    for (int cells = 1; cells <= 20; ++cells) {
      const SheetGrid grid = sheet_grid(cells, width, height, 0.8);
      EXPECT_GE(grid.columns * grid.rows, cells);
      EXPECT_LT((grid.columns - 1) * grid.rows, cells) << "an empty column";
      const double right = grid.area.x + grid.columns * (grid.cell_width_px + grid.gap_px) - grid.gap_px;
      const double bottom = grid.area.y + grid.rows * (grid.cell_height_px + grid.gap_px) - grid.gap_px;
      EXPECT_LE(right, width);
      EXPECT_LE(bottom, height);
    }
  }
  // Six pictures fill the page if their sides may be cut off.
  EXPECT_GT(sheet_grid(6, 1920, 1080, 0.6).cell_height_px, 1.3 * sheet_grid(6, 1920, 1080, 1).cell_height_px);
  const SheetGrid full = sheet_grid(16, 1920, 1080, 0.8);  // the most that a sheet has
  EXPECT_EQ(full.columns, 4);
  EXPECT_EQ(full.rows, 4);
}

/// With the pictures along the run its cells are these, reduced; without them they are rendered.
TEST_F(Views, TheContactSheetHasACellPerSnapshotInContact) {
  settings_.contact_sheet = true;
  std::vector<std::vector<int>> bone_px;  // of each cell, rendered and reduced
  for (const bool stills : {false, true}) {
    render({.stills = stills});
    const Picture sheet = picture("contact_sheet.png");
    ASSERT_EQ(sheet.width, kViewWidth);
    ASSERT_EQ(sheet.height, kViewHeight);
    const RunView view(dir_.path(), settings_);
    const std::vector<std::int64_t> shown = ContactSheet::frames_on(view);
    EXPECT_GE(shown.size(), 2U);
    EXPECT_LE(shown.size(), 7U);
    const Camera camera = view.camera("oblique", view.page().view_width_px, view.page().height_px);
    const SheetGrid grid = sheet_grid(static_cast<int>(shown.size()), kViewWidth, kViewHeight, camera.used_width);
    std::vector<int>& of_cells = bone_px.emplace_back();
    for (int i = 0; i < grid.columns * grid.rows; ++i) {
      const int x0 = static_cast<int>(grid.area.x) + i % grid.columns * (grid.cell_width_px + grid.gap_px);
      const int y0 = static_cast<int>(grid.area.y) + i / grid.columns * (grid.cell_height_px + grid.gap_px);
      int bone = 0;
      for (int y = y0; y < y0 + grid.cell_height_px; ++y) {
        for (int x = x0; x < x0 + grid.cell_width_px; ++x) bone += test::looks_like_bone(sheet.at(x, y)) ? 1 : 0;
      }
      if (bone <= 50) continue;
      of_cells.push_back(bone);
      EXPECT_EQ(static_cast<std::size_t>(i + 1), of_cells.size()) << "cells are filled by rows";
    }
    EXPECT_EQ(of_cells.size(), shown.size());
  }
  ASSERT_EQ(bone_px[0].size(), bone_px[1].size());
  for (std::size_t i = 0; i < bone_px[0].size(); ++i) EXPECT_NEAR(bone_px[1][i], bone_px[0][i], 0.25 * bone_px[0][i]);
}

TEST_F(Views, TheTurntableHasItsPicturesAndComesRound) {
  settings_.turntable_pictures = 4;
  render({.stills = false});
  for (const char* name : {"000.png", "001.png", "002.png", "003.png"}) {
    EXPECT_EQ(picture(std::string("turntable/") + name).width, kViewWidth) << name;
  }
  EXPECT_FALSE(fs::exists(dir_.path() + "/turntable/004.png"));
  // From the front the reamed face shows, from behind it does not.
  const auto unlike_bone = [&](const std::string& name) {
    const Picture seen = picture(name);
    int green = 0;
    for (int y = kViewHeight / 4; y < 3 * kViewHeight / 4; ++y) {
      for (int x = kViewWidth / 3; x < 2 * kViewWidth / 3; ++x) {
        const Eigen::Vector3i color = seen.at(x, y);
        green += color.y() > color.x() + 25 ? 1 : 0;
      }
    }
    return green;
  };
  EXPECT_GT(unlike_bone("turntable/000.png"), 500);
  EXPECT_LT(unlike_bone("turntable/002.png"), 20);
}

TEST_F(Views, ViewsOfAnySize) {
  settings_.before_after = settings_.contact_sheet = true;
  settings_.turntable_pictures = 1;
  for (const auto& [width, height] : {std::pair{33, 17}, {1, 1}, {321, 641}, {900, 210}}) {
    settings_.width_px = width;
    settings_.height_px = height;
    render({.stills = false});
    for (const char* name : {"before_after.png", "contact_sheet.png", "turntable/000.png"}) {
      const Picture seen = picture(name);
      EXPECT_EQ(seen.width, width) << name;
      EXPECT_EQ(seen.height, height) << name;
    }
  }
}

}  // namespace
}  // namespace reamsim
