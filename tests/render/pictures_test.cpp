// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "render/pictures/overlay.h"
#include "render/pictures/run_view.h"
#include "render/render.h"
#include "render/surface/bone_surface.h"
#include "sim/base/error.h"
#include "tests/render/picture_file.h"
#include "tests/render/results_fixture.h"
#include "tests/support/temp_dir.h"

namespace reamsim {
namespace {

using test::Picture;
using test::TempDir;
namespace fs = std::filesystem;

constexpr int kWidth = 960;
constexpr int kHeight = 540;
const PageLayout kPage = page_layout(kWidth, kHeight);

RenderSettings small_settings() {
  RenderSettings settings;
  settings.width_px = kWidth;
  settings.height_px = kHeight;
  settings.cameras = {CameraView::oblique, CameraView::glenoid, CameraView::section, CameraView::overview};
  return settings;
}

Eigen::Vector3i rgb(const Eigen::Vector3f& color) {
  return (255 * color).array().round().cast<int>();
}

/// One run, drawn once; its pictures are only read.
class Pictures : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    dir_ = new TempDir;
    truth_ = write_results(dir_->path(), {});
    render_pictures(dir_->path(), {.settings = small_settings()});
    target_ = new ViewTarget(RunData(dir_->path()).target());
  }
  static void TearDownTestSuite() {
    delete target_;
    delete dir_;
  }

  static Picture picture(const std::string& name) { return test::read_picture(dir_->path() + "/" + name); }
  static Camera camera(const std::string& name) {
    return make_camera(from_name<CameraView>(name).value(), *target_, kPage.view_width_px, kHeight);
  }
  /// The colour where a point of the glenoid frame falls.
  static Eigen::Vector3i color_at(const Picture& picture, const Camera& camera, const Vec3& glenoid_mm) {
    const Vec2 at = camera.pixel(truth_.bone_from_glenoid * glenoid_mm);
    return picture.at(static_cast<int>(at.x()), static_cast<int>(at.y()));
  }
  /// The background at a row: nothing is ever drawn in the middle of the lower edge of these pictures.
  static bool is_background(const Eigen::Vector3i& color) {
    return color.z() >= color.y() && color.y() >= color.x() && color.x() > 190 && color.z() - color.x() < 20;
  }

  static TempDir* dir_;
  static FixtureTruth truth_;
  static ViewTarget* target_;
};

TempDir* Pictures::dir_ = nullptr;
FixtureTruth Pictures::truth_;
ViewTarget* Pictures::target_ = nullptr;

TEST_F(Pictures, EverySnapshotAndTheLastStateHaveOnePictureForEachCamera) {
  for (const char* stem : {"frames/000000", "frames/000020", "frames/000040", "frames/000060", "reamed"}) {
    for (const char* suffix : {"", "_glenoid", "_section", "_overview"}) {
      const Picture shown = picture(std::string(stem) + suffix + ".png");
      EXPECT_EQ(shown.width, kWidth) << stem << suffix;
      EXPECT_EQ(shown.height, kHeight) << stem << suffix;
    }
  }
  EXPECT_FALSE(fs::exists(dir_->path() + "/frames/000000_oblique.png"));
}

TEST_F(Pictures, TheFaceIsBoneBeforeReamingAndHasTheColourOfItsDepthAfterwards) {
  const Camera face_on = camera("glenoid");
  const Vec3 place(4, -4, -2);
  EXPECT_TRUE(test::looks_like_bone(color_at(picture("frames/000000_glenoid.png"), face_on, place)));

  // The face is a sphere of 32 mm about (0, 0, 32), the tool's one of 29 mm about (0, 0, 26).
  const double new_z = 26 - std::sqrt(29 * 29 - 32.0);
  const double depth_mm = (Vec3(4, -4, new_z) - Vec3(0, 0, 32)).norm() - 32;
  const Eigen::Vector3i expected = rgb(depth_colors().at(depth_mm / 3.5));
  const Eigen::Vector3i found = color_at(picture("reamed_glenoid.png"), face_on, place);
  EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 50) << found.transpose() << " against " << expected.transpose();
  EXPECT_FALSE(test::looks_like_bone(found));
}

TEST_F(Pictures, UnreamedBoneKeepsItsColour) {
  const Camera face_on = camera("glenoid");
  EXPECT_TRUE(test::looks_like_bone(color_at(picture("reamed_glenoid.png"), face_on, Vec3(0, -16.5, 0))));
  EXPECT_TRUE(test::looks_like_bone(color_at(picture("reamed_glenoid.png"), face_on, Vec3(0, 16, 0))));
}

TEST_F(Pictures, SuperiorIsUp) {
  // The bump sticks out of the superior rim; seen from anterior there is nothing opposite to it.
  const Picture shown = picture("reamed_section.png");
  const Camera section = camera("section");
  EXPECT_FALSE(is_background(color_at(shown, section, Vec3(0, truth_.bump_mm, 0.5))));
  EXPECT_TRUE(is_background(color_at(shown, section, Vec3(0, -truth_.bump_mm, 0.5))));
  const Vec2 bump = section.pixel(truth_.bone_from_glenoid * Vec3(0, truth_.bump_mm, 0.5));
  const Vec2 middle = section.pixel(truth_.bone_from_glenoid * Vec3(0, 0, 0.5));
  EXPECT_LT(bump.y(), middle.y() - 50);
}

TEST_F(Pictures, TheCutFaceShowsDensities) {
  const Picture shown = picture("reamed_section.png");
  const Camera section = camera("section");
  // The shell is 1.8 mm thick at the ellipsoid's equator and 1.55 g/cm³ dense.
  const Eigen::Vector3i shell = color_at(shown, section, Vec3(0, -17.1, -16));
  EXPECT_LT((shell - rgb(density_colors().at(1.55 / 2))).cwiseAbs().maxCoeff(), 12) << shell.transpose();
  // Inside it varies between 0.30 and 0.60.
  int darkest = 255;
  int lightest = 0;
  for (double y = -10; y <= 10; y += 0.25) {
    const Eigen::Vector3i inside = color_at(shown, section, Vec3(0, y, -16));
    darkest = std::min(darkest, inside.y());
    lightest = std::max(lightest, inside.y());
  }
  EXPECT_GE(darkest, rgb(density_colors().at(0.30 / 2)).y() - 6);
  EXPECT_LE(lightest, rgb(density_colors().at(0.60 / 2)).y() + 6);
  EXPECT_GT(lightest - darkest, 10);
  // What was reamed away is air on the cut face.
  const Eigen::Vector3i air = color_at(shown, section, Vec3(0, -5, -0.8));
  EXPECT_GT((air - rgb(density_colors().at(1.55 / 2))).cwiseAbs().maxCoeff(), 20);
}

TEST_F(Pictures, TheToolIsSeeThrough) {
  const Camera oblique = camera("oblique");
  const Vec3 under_the_head(-3, -3, -2.5);
  const Eigen::Vector3i through = color_at(picture("frames/000040.png"), oblique, under_the_head);
  const Eigen::Vector3i bare = color_at(picture("reamed.png"), oblique, under_the_head);
  const int difference = (through - bare).cwiseAbs().maxCoeff();
  EXPECT_GT(difference, 8) << "the tool is not there";
  EXPECT_GT(through.y(), through.z() + 5) << "the green of the depth does not come through: " << through.transpose();
}

TEST_F(Pictures, FaceOnTheToolIsAnOutlineOnly) {
  const Camera face_on = camera("glenoid");
  const Picture with_tool = picture("frames/000040_glenoid.png");
  int outlined = 0;
  for (int degree = 0; degree < 360; degree += 2) {
    const double turn = degree * 3.14159265358979 / 180;
    const Vec3 on_circle(truth_.head_radius_mm * std::cos(turn), truth_.head_radius_mm * std::sin(turn), 0);
    const Eigen::Vector3i color = color_at(with_tool, face_on, on_circle);
    if (color.x() < 120 && color.z() > color.x()) ++outlined;
  }
  EXPECT_GT(outlined, 60);
  const Eigen::Vector3i inside = color_at(with_tool, face_on, Vec3(-3, 3, -2));
  EXPECT_GT(inside.y(), inside.z() + 40) << "the reamed face is not free to be seen";
}

TEST_F(Pictures, TheLegendShowsTheColoursAndTheScaleBarItsLength) {
  const Picture shown = picture("reamed.png");
  const Camera oblique = camera("oblique");
  const Box bar = kPage.legend_bar(0);
  const int x = static_cast<int>(bar.x + bar.width / 2);
  const Eigen::Vector3i top = shown.at(x, static_cast<int>(bar.y) + 3);
  const Eigen::Vector3i bottom = shown.at(x, static_cast<int>(bar.y + bar.height) - 3);
  EXPECT_LT((top - rgb(depth_colors().at(0.99))).cwiseAbs().maxCoeff(), 12);
  EXPECT_LT((bottom - rgb(depth_colors().at(0.01))).cwiseAbs().maxCoeff(), 12);

  const auto [scale, length_mm] = kPage.scale_bar(oblique);
  int dark = 0;
  const int y = static_cast<int>(scale.y + scale.height / 2);
  for (int column = kPage.view_width_px; column < kWidth; ++column) dark += shown.at(column, y).maxCoeff() < 60 ? 1 : 0;
  EXPECT_NEAR(dark * oblique.mm_per_px, length_mm, 2 * oblique.mm_per_px);
}

TEST_F(Pictures, NumbersStandBesideTheLegendAndInTheCorner) {
  const Picture shown = picture("frames/000040.png");
  const auto ink_in = [&](const Box& box) {
    int ink = 0;
    for (int y = static_cast<int>(box.y); y < box.y + box.height; ++y) {
      for (int x = static_cast<int>(box.x); x < box.x + box.width; ++x) ink += shown.at(x, y).maxCoeff() < 90 ? 1 : 0;
    }
    return ink;
  };
  const Box bar = kPage.legend_bar(0);
  EXPECT_GT(ink_in({bar.x + bar.width + 6, bar.y - 6, 45, bar.height + 12}), 100);
  const Box labels = kPage.labels();
  EXPECT_GT(ink_in({labels.x, labels.y, labels.width, 0.3 * labels.height}), 200);
}

TEST_F(Pictures, TheSameRunGivesTheSameBytes) {
  const std::string before = test::file_bytes(dir_->path() + "/frames/000040_section.png");
  RenderSettings settings = small_settings();
  settings.cameras = {CameraView::oblique, CameraView::section};
  render_pictures(dir_->path(), {.settings = settings});
  EXPECT_EQ(test::file_bytes(dir_->path() + "/frames/000040_section.png"), before);
}

class OtherPictures : public ::testing::Test {
 protected:
  void SetUp() override {
    FixtureOptions options;
    options.voxel_mm = 1;
    options.every = 60;
    write_results(dir_.path(), options);
    settings_.width_px = 320;
    settings_.height_px = 240;
    settings_.cameras = {CameraView::oblique};
  }
  void render() { render_pictures(dir_.path(), {.settings = settings_}); }

  TempDir dir_;
  RenderSettings settings_;
};

TEST_F(OtherPictures, AnySizeIsDrawn) {
  for (const auto& [width, height] : {std::pair{33, 17}, {4096, 16}, {1, 1}, {640, 1080}, {1921, 1079}}) {
    settings_.width_px = width;
    settings_.height_px = height;
    settings_.cameras = {CameraView::section};
    render();
    const Picture shown = test::read_picture(dir_.path() + "/reamed.png");
    EXPECT_EQ(shown.width, width);
    EXPECT_EQ(shown.height, height);
  }
}

TEST_F(OtherPictures, OSMesaAndEglGiveTheSamePicture) {
  settings_.cameras = {CameraView::oblique, CameraView::section};
  for (const RenderContext context : {RenderContext::osmesa, RenderContext::egl}) {
    settings_.context = context;
    Diagnostics report;
    render_pictures(dir_.path(), {.settings = settings_}, nullptr, &report);
    if (!report.warnings.empty()) GTEST_SKIP() << "this machine has only one of the two: " << report.warnings.front();
    fs::rename(dir_.path() + "/frames", dir_.path() + "/frames_" + name_of(context));
  }
  for (const char* name : {"/000060.png", "/000060_section.png"}) {
    const Picture a = test::read_picture(dir_.path() + "/frames_osmesa" + name);
    const Picture b = test::read_picture(dir_.path() + "/frames_egl" + name);
    ASSERT_EQ(a.pixels.size(), b.pixels.size());
    EXPECT_LE(test::largest_difference(a, b), 2);
  }
}

TEST_F(OtherPictures, ProgressCountsEveryPicture) {
  std::vector<int> done;
  int total = 0;
  settings_.cameras = {CameraView::oblique, CameraView::glenoid};
  render_pictures(dir_.path(), {.settings = settings_}, [&](int now, int all, const std::string& file) {
    done.push_back(now);
    total = all;
    EXPECT_TRUE(fs::exists(file));
  });
  // Of each camera two along the run, the last, and before and after; and the contact sheet.
  EXPECT_THAT(done, ::testing::ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9));
  EXPECT_EQ(total, 9);
}

TEST_F(OtherPictures, ARunWithoutGlenoidFrameIsSeenAlongTheTool) {
  TempDir other;
  FixtureOptions options;
  options.voxel_mm = 1;
  options.every = 60;
  options.glenoid = false;
  options.side = BodySide::unknown;
  const FixtureTruth truth = write_results(other.path(), options);
  settings_.cameras = {CameraView::glenoid};
  render_pictures(other.path(), {.settings = settings_});
  const RunData run(other.path());
  const ViewTarget& target = run.target();
  EXPECT_FALSE(target.anatomical);
  EXPECT_GT(target.outward.dot(truth.bone_from_glenoid.linear().col(2)), 0.999);
}

TEST_F(OtherPictures, ABoneThatWasNeverTouchedHasNoDepthColour) {
  TempDir other;
  FixtureOptions options;
  options.voxel_mm = 1;
  options.every = 60;
  options.depth_mm = -1;
  write_results(other.path(), options);
  settings_.cameras = {CameraView::glenoid};
  render_pictures(other.path(), {.settings = settings_});
  const Picture shown = test::read_picture(other.path() + "/reamed.png");
  EXPECT_TRUE(test::looks_like_bone(shown.at(160, 130)));
}

TEST_F(OtherPictures, TheToolCanBeLeftOut) {
  settings_.tool = false;
  render();
  const Picture without = test::read_picture(dir_.path() + "/frames/000000.png");
  settings_.tool = true;
  render();
  EXPECT_GT(test::largest_difference(without, test::read_picture(dir_.path() + "/frames/000000.png")), 20);
}

TEST_F(OtherPictures, DamagedResultsAreInputErrors) {
  const std::string dir = dir_.path();
  const auto expect_complaint = [&](const std::string& about) {
    try {
      render();
      ADD_FAILURE() << "no complaint about " << about;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr(about));
      EXPECT_THAT(error.what(), ::testing::Not(::testing::HasSubstr("\n")));
    }
  };
  const auto without = [&](const std::string& name, const std::string& about) {
    fs::rename(dir + "/" + name, dir + "/aside");
    expect_complaint(about);
    fs::rename(dir + "/aside", dir + "/" + name);
  };
  const auto cut_short = [&](const std::string& name) {
    fs::copy_file(dir + "/" + name, dir + "/aside");
    fs::resize_file(dir + "/" + name, fs::file_size(dir + "/" + name) / 2);
    expect_complaint(name);
    fs::rename(dir + "/aside", dir + "/" + name);
  };
  without("reamed.vdb", "reamed.vdb");
  without("forces.csv", "forces.csv");
  without("snapshots", "snapshots");
  without("snapshots/tool.stl", "tool.stl");
  cut_short("reamed.vdb");
  cut_short("snapshots/000060.vdb");
  cut_short("snapshots/tool.stl");
  EXPECT_NO_THROW(render());
  EXPECT_THROW(render_pictures(dir + "/nowhere", {.settings = settings_}), InputError);
}

TEST_F(OtherPictures, NoCameraAndNoWidthAreInputErrors) {
  settings_.cameras = {};
  EXPECT_THROW(render(), InputError);
  settings_.cameras = {CameraView::oblique};
  settings_.width_px = 0;
  EXPECT_THROW(render(), InputError);
}

TEST_F(OtherPictures, WhatCannotBeDrawnOrWrittenIsARunError) {
  settings_.width_px = 1'000'000;
  EXPECT_THROW(render(), RunError);
  settings_.width_px = 320;
  fs::remove_all(dir_.path() + "/frames");
  std::ofstream(dir_.path() + "/frames") << "a file where the folder should be";
  EXPECT_THROW(render(), RunError);
  PixelImage image = plain_image(4, 4, 0);
  EXPECT_THROW(write_png("/dev/full", image), RunError);
}

}  // namespace
}  // namespace reamsim
