// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Jagged edges of known shapes, smoothed, against the fraction of each pixel that the shape covers.
#include "render/gl/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tests/render/opened_run.h"
#include "tests/render/picture_file.h"
#include "tests/render/results_fixture.h"
#include "tests/support/temp_dir.h"

namespace reamsim {
namespace {

constexpr int kSide_px = 96;

std::uint32_t gray(double fraction) {
  const auto value = static_cast<std::uint32_t>(std::lround(255 * fraction));
  return 0xff000000U | value << 16 | value << 8 | value;
}

/// A picture of a shape, every pixel the mean of samples x samples points of it.
PixelImage drawn(const std::function<bool(double, double)>& inside, int samples) {
  PixelImage out = plain_image(kSide_px, kSide_px, 0);
  for (int y = 0; y < kSide_px; ++y) {
    for (int x = 0; x < kSide_px; ++x) {
      int hits = 0;
      for (int i = 0; i < samples * samples; ++i) {
        const double u = x + (i % samples + 0.5) / samples;
        const double v = y + (i / samples + 0.5) / samples;
        hits += inside(u, v) ? 1 : 0;
      }
      out.pixels[static_cast<std::size_t>(y * kSide_px + x)] = gray(double(hits) / (samples * samples));
    }
  }
  return out;
}

/// RMS of the difference in brightness, 8 pixels off the picture's border.
double difference(const PixelImage& a, const PixelImage& b) {
  double sum = 0;
  int count = 0;
  for (int y = 8; y < kSide_px - 8; ++y) {
    for (int x = 8; x < kSide_px - 8; ++x) {
      const auto i = static_cast<std::size_t>(y * kSide_px + x);
      const double d = int(a.pixels[i] & 255U) - int(b.pixels[i] & 255U);
      sum += d * d;
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

TEST(EdgeFilter, StraightEdgesComeNearTheirTrueFractions) {
  for (const double degrees : {3.0, 10.0, 20.0, 30.0, 40.0, 50.0, 70.0, 85.0, 130.0, 170.0}) {
    const double c = std::cos(degrees * M_PI / 180);
    const double s = std::sin(degrees * M_PI / 180);
    const auto half_plane = [&](double x, double y) { return c * (y - 47.3) > s * (x - 47.6); };
    const PixelImage jagged = drawn(half_plane, 1);
    const PixelImage truth = drawn(half_plane, 16);
    EXPECT_LT(difference(antialiased(jagged), truth), 0.6 * difference(jagged, truth)) << degrees;
  }
}

TEST(EdgeFilter, ADiscComesNearItsTrueFractions) {
  const auto disc = [](double x, double y) { return std::hypot(x - 48.2, y - 47.9) < 30; };
  const PixelImage jagged = drawn(disc, 1);
  const PixelImage truth = drawn(disc, 16);
  EXPECT_LT(difference(antialiased(jagged), truth), 0.6 * difference(jagged, truth));
}

TEST(EdgeFilter, FlatPartsAndSlowShadesStayAsTheyAre) {
  PixelImage image = plain_image(kSide_px, kSide_px, 0x8090a0);
  for (int i = 0; i < kSide_px * kSide_px; ++i) {
    image.pixels[static_cast<std::size_t>(i)] = gray((i % kSide_px + i / kSide_px) / (2.0 * kSide_px));
  }
  EXPECT_EQ(antialiased(image).pixels, image.pixels);
}

TEST(EdgeFilter, AnEdgeAgainstNothingIsSmoothedToo) {
  // Black on nothing: all its channels but the opacity are the same on both sides.
  const auto half_plane = [](double x, double y) { return y - 48 > 0.2 * (x - 48); };
  PixelImage image = drawn(half_plane, 1);
  for (std::uint32_t& pixel : image.pixels) pixel = pixel == 0xffffffffU ? 0xff000000U : 0;
  int half_clear = 0;
  for (const std::uint32_t pixel : antialiased(image).pixels) {
    EXPECT_EQ(pixel & 0xffffffU, 0U);
    half_clear += pixel >> 24 != 0 && pixel >> 24 != 255 ? 1 : 0;
  }
  EXPECT_GT(half_clear, kSide_px / 2);
}

// The filter softens contour lines, which are little more than a pixel wide here: 3.5 with them.
TEST(EdgeFilter, AFilmsFrameLooksLikeThePicture) {
  const test::TempDir dir;
  write_results(dir.path(), {});
  RenderSettings settings;
  settings.width_px = 720;
  settings.height_px = 480;
  test::OpenedRun opened(dir.path(), settings);
  opened.renderer.advance_to_last();
  for (const char* name : {"oblique", "section"}) {
    const Camera camera = opened.camera(name);
    const auto tool = opened.view.tool_at(opened.last_row().frame);
    PixelImage sampled = opened.renderer.render(camera, tool);
    PixelImage smoothed = opened.renderer.render(camera, tool, true);
    write_png(dir.path() + "/sampled.png", sampled);
    write_png(dir.path() + "/smoothed.png", smoothed);
    const test::Picture a = test::read_picture(dir.path() + "/sampled.png");
    const test::Picture b = test::read_picture(dir.path() + "/smoothed.png");
    EXPECT_LT(test::perceived_difference(a, b), 4) << name;
    EXPECT_GT(test::largest_difference(a, b), 0) << name;
  }
}

}  // namespace
}  // namespace reamsim
