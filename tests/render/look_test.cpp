// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// What the keys background, supersampling and force_arrow do to a picture.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "render/gl/camera.h"
#include "render/pictures/overlay.h"
#include "render/render.h"
#include "tests/render/picture_file.h"
#include "tests/render/results_fixture.h"
#include "tests/support/temp_dir.h"

namespace reamsim {
namespace {

using test::Picture;

class Look : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    dir_ = new test::TempDir;
    write_results(dir_->path(), {.voxel_mm = 1, .every = 40});
  }
  static void TearDownTestSuite() { delete dir_; }
  void SetUp() override {
    settings_.width_px = 320;
    settings_.height_px = 240;
    settings_.cameras = {CameraView::oblique};
    settings_.before_after = settings_.contact_sheet = false;
  }

  [[nodiscard]] Picture draw(const std::string& name) const {
    render_pictures(dir_->path(), {settings_});
    return test::read_picture(dir_->path() + "/" + name + ".png");
  }
  static int alpha(const Picture& picture, int x, int y) {
    return static_cast<int>(picture.pixels.at(static_cast<std::size_t>(y * picture.width + x)) >> 24);
  }

  static test::TempDir* dir_;
  RenderSettings settings_;
};

test::TempDir* Look::dir_ = nullptr;

TEST_F(Look, AWhiteBackgroundIsWhite) {
  settings_.background = Background::white;
  const Picture shown = draw("reamed");
  EXPECT_EQ(shown.at(160, 2), Eigen::Vector3i(255, 255, 255));
  EXPECT_EQ(shown.at(160, 237), Eigen::Vector3i(255, 255, 255));
  EXPECT_NE(shown.at(160, 120), Eigen::Vector3i(255, 255, 255));
}

TEST_F(Look, ATransparentBackgroundIsNothingAndTheBoneOpaque) {
  settings_.supersampling = 2;  // edges by samples in both pictures
  settings_.background = Background::white;
  const Picture white = draw("frames/000040");
  settings_.background = Background::transparent;
  const Picture clear = draw("frames/000040");
  EXPECT_EQ(alpha(clear, 160, 237), 0);
  EXPECT_EQ(alpha(clear, 160, 150), 255);
  // Laid on white it is the picture on white, also where the tool is see-through.
  int most = 0;
  for (int y = 0; y < clear.height; ++y) {
    for (int x = 0; x < page_layout(clear.width, clear.height).view_width_px; ++x) {
      const Eigen::Vector3i on_white = clear.at(x, y) + Eigen::Vector3i::Constant(255 - alpha(clear, x, y));
      most = std::max(most, (on_white - white.at(x, y)).cwiseAbs().maxCoeff());
    }
  }
  EXPECT_LE(most, 3);
}

TEST_F(Look, SupersamplingKeepsThePictureAndSmoothsIt) {
  const Picture plain = draw("reamed");
  for (const int times : {2, 3, 4}) {
    settings_.supersampling = times;
    const Picture fine = draw("reamed");
    ASSERT_EQ(fine.width, plain.width);
    EXPECT_LT(test::perceived_difference(fine, plain), 2) << times;
    EXPECT_GT(test::largest_difference(fine, plain), 5) << times;
  }
}

TEST_F(Look, TheArrowIsRedAndOnlyWhereThereIsForce) {
  const auto reds = [](const Picture& picture) {
    int count = 0;
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x) {
        const Eigen::Vector3i c = picture.at(x, y);
        count += c.x() > 170 && c.y() < 60 && c.z() < 80 ? 1 : 0;
      }
    }
    return count;
  };
  EXPECT_GT(reds(draw("frames/000040")), 60);
  EXPECT_EQ(reds(test::read_picture(dir_->path() + "/frames/000000.png")), 0);
  settings_.force_arrow = false;
  EXPECT_EQ(reds(draw("frames/000040")), 0);
}

TEST(Averaged, EveryPixelIsTheMeanOfItsSquare) {
  PixelImage image = plain_image(4, 2, 0x000000);
  image.pixels = {0xff000010, 0xff000020, 0x00000000, 0x00000000, 0xff000030, 0xff000040, 0x00000000, 0x80400000};
  const PixelImage half = downsampled(image, 2);
  EXPECT_EQ(half.width_px, 2);
  EXPECT_EQ(half.height_px, 1);
  EXPECT_EQ(half.pixels, (std::vector<std::uint32_t>{0xff000028, 0x20100000}));
}

TEST(Paste, ATransparentPartShowsWhatLiesBelow) {
  PixelImage page = plain_image(2, 1, 0xffffff);
  PixelImage part{2, 1, {0x00000000, 0x80400000}};
  page.paste(part, 0, 0);
  EXPECT_EQ(page.pixels, (std::vector<std::uint32_t>{0xffffffff, 0xffbf7f7f}));
}

}  // namespace
}  // namespace reamsim
