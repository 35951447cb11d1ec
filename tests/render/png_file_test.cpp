// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// What write_png() writes, read back by Cairo.
#include <gtest/gtest.h>

#include <random>

#include "render/pictures/canvas.h"
#include "sim/base/error.h"
#include "tests/render/picture_file.h"
#include "tests/support/temp_dir.h"

namespace reamsim {
namespace {

class PngFile : public testing::Test {
 protected:
  /// Smooth here and noisy there, so that every prediction and every length of run comes up.
  static PixelImage picture(bool opaque) {
    std::mt19937 random(19);
    PixelImage out = plain_image(61, 43, 0);
    for (std::size_t i = 0; i < out.pixels.size(); ++i) {
      const auto noise = i % 3 == 0 ? static_cast<std::uint32_t>(random()) : 0x102030U + static_cast<std::uint32_t>(i);
      const std::uint32_t alpha = opaque ? 255 : static_cast<std::uint32_t>(i % 7 * 42);
      std::uint32_t pixel = alpha << 24;
      for (int shift = 0; shift < 24; shift += 8) pixel |= (noise >> shift & 255U) * alpha / 255 << shift;
      out.pixels[i] = pixel;
    }
    return out;
  }

  test::Picture written_by_cairo(PixelImage image) {
    cairo_surface_write_to_png(Canvas(image).surface(), path("cairo").c_str());
    return test::read_picture(path("cairo"));
  }

  [[nodiscard]] std::string path(const std::string& name) const { return dir_.path() + "/" + name + ".png"; }

  test::TempDir dir_;
};

TEST_F(PngFile, KeepsEveryPixelOfAnOpaquePicture) {
  const PixelImage image = picture(true);
  write_png(path("ours"), image);
  const test::Picture back = test::read_picture(path("ours"));
  ASSERT_EQ(back.width, image.width_px);
  ASSERT_EQ(back.height, image.height_px);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    ASSERT_EQ(back.pixels[i] & 0xffffffU, image.pixels[i] & 0xffffffU) << i;
  }
}

TEST_F(PngFile, KeepsOpacityAsCairoDoes) {
  const PixelImage image = picture(false);
  write_png(path("ours"), image);
  const test::Picture back = test::read_picture(path("ours"));
  ASSERT_EQ(back.pixels.size(), image.pixels.size());
  EXPECT_EQ(back.pixels, written_by_cairo(image).pixels);
}

TEST_F(PngFile, ThatCannotBeWrittenIsARunError) {
  for (const std::string& nowhere : {dir_.path(), dir_.path() + "/no/such/folder.png", std::string("/dev/full")}) {
    try {
      write_png(nowhere, picture(true));
      ADD_FAILURE() << nowhere;
    } catch (const RunError& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with(nowhere + ": cannot be written (")) << error.what();
    }
  }
}

}  // namespace
}  // namespace reamsim
