// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Pictures of a small run against those in golden/, by what an eye would notice. After a wanted change of the look:
//   REAMSIM_NEW_GOLDEN=1 build/release/tests/render/render_test --gtest_filter='Golden.*'
// then look at each of them at full size before it is committed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>

#include "render/render.h"
#include "tests/render/opened_run.h"
#include "tests/render/picture_file.h"
#include "tests/render/results_fixture.h"
#include "tests/support/temp_dir.h"

namespace reamsim {
namespace {

using test::Picture;
using test::TempDir;

/// Other versions of OpenGL, Pango and their fonts stay below; whatever is wrong with a picture goes beyond.
constexpr double kTolerance = 3.0;
const std::vector<std::string> kNames{"reamed", "reamed_glenoid", "reamed_section", "frames/000040",
                                      "frames/000040_section"};

RenderSettings golden_settings() {
  RenderSettings settings;
  settings.width_px = 720;
  settings.height_px = 480;
  settings.cameras = {CameraView::oblique, CameraView::glenoid, CameraView::section};
  settings.before_after = settings.contact_sheet = false;
  return settings;
}

std::string golden_path(const std::string& name) {
  std::string file = name;
  std::ranges::replace(file, '/', '_');
  return REAMSIM_GOLDEN "/" + file + ".png";
}

class Golden : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    dir_ = new TempDir;
    write_results(dir_->path(), {});
  }
  static void TearDownTestSuite() { delete dir_; }
  // Its OpenGL context is current until another is made.
  void TearDown() override {
    delete opened_;
    opened_ = nullptr;
  }

  static std::string path(const std::string& name) { return dir_->path() + "/" + name + ".png"; }

  /// How much pictures of the same run, drawn with other settings, differ from the golden ones.
  static std::map<std::string, double> differences_with(const RenderSettings& settings,
                                                        const std::vector<std::string>& names = kNames) {
    render_pictures(dir_->path(), {settings});
    std::map<std::string, double> out;
    for (const std::string& name : names) out[name] = difference(test::read_picture(path(name)), name);
    return out;
  }
  /// The same for the last state, drawn in parts; `spoil` may change the picture or the labels.
  template <typename Spoil>
  static double difference_after(const std::string& camera_name, const std::string& name, Spoil spoil) {
    if (opened_ == nullptr) {
      opened_ = new test::OpenedRun(dir_->path(), golden_settings());
      opened_->renderer.advance_to_last();
    }
    const Camera camera = opened_->camera(camera_name);
    PixelImage image = opened_->renderer.render(camera, std::nullopt);
    Labels labels = opened_->view.labels(camera, std::nullopt);
    spoil(image, labels);
    PixelImage page = annotated_picture(image, opened_->view.page(), camera, labels, Background::studio);
    const std::string file = dir_->path() + "/spoiled.png";
    write_png(file, page);
    return difference(test::read_picture(file), name);
  }
  static double difference(const Picture& picture, const std::string& name) {
    const Picture golden = test::read_picture(golden_path(name));
    EXPECT_EQ(golden.width, picture.width) << name;
    EXPECT_EQ(golden.height, picture.height) << name;
    return test::perceived_difference(picture, golden);
  }

  static TempDir* dir_;
  static test::OpenedRun* opened_;  ///< its last state
};

TempDir* Golden::dir_ = nullptr;
test::OpenedRun* Golden::opened_ = nullptr;

TEST_F(Golden, PicturesLookAsTheyDid) {
  if (std::getenv("REAMSIM_NEW_GOLDEN") != nullptr) {
    render_pictures(dir_->path(), {golden_settings()});
    for (const std::string& name : kNames) {
      std::filesystem::copy_file(path(name), golden_path(name), std::filesystem::copy_options::overwrite_existing);
    }
  }
  for (const auto& [name, found] : differences_with(golden_settings())) EXPECT_LT(found, kTolerance) << name;
}

TEST_F(Golden, AWrongLightIsSeen) {
  RenderSettings settings = golden_settings();
  settings.light.x() *= -1;
  for (const auto& [name, found] : differences_with(settings)) EXPECT_GT(found, 2 * kTolerance) << name;
}

TEST_F(Golden, AMirroredAxisIsSeen) {
  for (const char* camera : {"oblique", "glenoid", "section"}) {
    const std::string name = std::string(camera) == "oblique" ? "reamed" : std::string("reamed_") + camera;
    const auto mirror = [](PixelImage& image, Labels&) {
      for (int y = 0; y < image.height_px; ++y) {
        const auto row = image.pixels.begin() + std::ptrdiff_t{image.width_px} * y;
        std::reverse(row, row + image.width_px);
      }
    };
    EXPECT_GT(difference_after(camera, name, mirror), 2 * kTolerance) << name;
  }
}

TEST_F(Golden, AMissingLegendIsSeen) {
  // The box of values is missing as well in these; without it alone the difference is that of the box.
  const auto drop_legends = [](PixelImage&, Labels& labels) { labels.legends.clear(); };
  const auto keep_legends = [](PixelImage&, Labels&) {};
  for (const char* camera : {"glenoid", "section"}) {
    const std::string name = std::string("reamed_") + camera;
    const double without = difference_after(camera, name, drop_legends);
    EXPECT_GT(without, 2 * kTolerance) << name;
    EXPECT_GT(without, 1.2 * difference_after(camera, name, keep_legends)) << name;
  }
}

TEST_F(Golden, AMissingArrowOrAnotherLookOfTheToolIsSeen) {
  RenderSettings settings = golden_settings();
  settings.cameras = {CameraView::oblique};
  settings.force_arrow = false;
  EXPECT_GT(differences_with(settings, {"frames/000040"})["frames/000040"], 2 * kTolerance);
  settings.force_arrow = true;
  settings.tool_material = ToolMaterial::steel;
  EXPECT_GT(differences_with(settings, {"frames/000040"})["frames/000040"], 2 * kTolerance);
}

}  // namespace
}  // namespace reamsim
