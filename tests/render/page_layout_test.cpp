// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Labels beside the bone: none covers it, and on a transparent background they are legible on any slide.
#include "render/pictures/overlay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/pictures/figures.h"
#include "render/render.h"
#include "tests/render/opened_run.h"
#include "tests/render/results_fixture.h"
#include "tests/support/temp_dir.h"

namespace reamsim {
namespace {

constexpr int kWidth = 960;
constexpr int kHeight = 540;
constexpr std::array kViews{"oblique", "glenoid", "section", "overview"};

bool inside(const Box& inner, const Box& outer) {
  return inner.x >= outer.x && inner.y >= outer.y && inner.x + inner.width <= outer.x + outer.width &&
         inner.y + inner.height <= outer.y + outer.height;
}

TEST(PageLayoutTest, EveryLabelHasItsPlaceBesideTheView) {
  for (const auto& [width, height] : {std::pair{1920, 1080}, {640, 360}, {1080, 1920}, {200, 200}, {4096, 2160}}) {
    const PageLayout page = page_layout(width, height);
    EXPECT_GT(page.view_width_px, 0.7 * width);
    const Box labels = page.labels();
    EXPECT_GE(labels.x, page.view_width_px);
    EXPECT_LE(labels.x + labels.width, width);
    Camera camera;
    camera.width_px = page.view_width_px;
    camera.height_px = height;
    for (const double mm_per_px : {0.01, 0.0499, 0.05, 1.0}) {
      camera.mm_per_px = mm_per_px;
      EXPECT_TRUE(inside(page.scale_bar(camera).first, labels));
    }
    for (const int index : {0, 1}) {
      const Box bar = page.legend_bar(index);
      EXPECT_TRUE(inside(bar, labels));
      EXPECT_GT(bar.height, 250 * page.unit) << width << ' ' << height;
      EXPECT_GT(bar.y, page.values_y());
      EXPECT_LT(bar.y + bar.height, page.directions_px().y());
    }
    EXPECT_LT(page.directions_px().y(), page.scale_bar(camera).first.y);
  }
  EXPECT_FALSE(page_layout(199, 300).labelled());
  EXPECT_EQ(page_layout(33, 17).view_width_px, 33);
}

class Page : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    dir_ = new test::TempDir;
    write_results(dir_->path(), {.voxel_mm = 1});
  }
  static void TearDownTestSuite() { delete dir_; }

  static RenderSettings settings(Background background) {
    RenderSettings settings;
    settings.width_px = kWidth;
    settings.height_px = kHeight;
    settings.background = background;
    return settings;
  }
  /// All labels in the column that a picture of the last state has.
  static Labels column_labels(const test::OpenedRun& run, const Camera& camera) {
    Labels labels = run.view.labels(camera, std::nullopt);
    labels.title = "After reaming";
    labels.values = run.captions.after(3);
    return labels;
  }

  static test::TempDir* dir_;
};

test::TempDir* Page::dir_ = nullptr;

TEST_F(Page, NoPanelCoversTheBone) {
  test::OpenedRun run(dir_->path(), settings(Background::transparent));
  run.renderer.advance_to_last();
  for (const char* name : kViews) {
    const Camera camera = run.camera(name);
    const PixelImage bone = run.renderer.render(camera, std::nullopt);
    const PixelImage page =
        annotated_picture(bone, run.view.page(), camera, column_labels(run, camera), Background::transparent);
    ASSERT_EQ(page.width_px, kWidth);
    ASSERT_EQ(page.height_px, kHeight);
    int hidden = 0;
    int shown = 0;
    for (int y = 0; y < bone.height_px; ++y) {
      for (int x = 0; x < bone.width_px; ++x) {
        shown += bone.pixels[bone.index(x, y)] != 0 ? 1 : 0;
        hidden += page.pixels[page.index(x, y)] != bone.pixels[bone.index(x, y)] ? 1 : 0;
      }
    }
    EXPECT_EQ(hidden, 0) << name;
    EXPECT_GT(shown, 0.1 * kWidth * kHeight) << name;
  }
}

TEST_F(Page, NorInFilmsAndBesideBeforeAndAfter) {
  const test::OpenedRun run(dir_->path(), settings(Background::transparent));
  const Box bone = film_layout(kWidth, kHeight).bone;
  EXPECT_LT(film_camera(run.view, "oblique").width_px, 0.85 * bone.width) << "a column for the labels";
  const Camera half = half_camera(run.view, "oblique");
  EXPECT_LT(half.height_px, kHeight) << "titles above the halves";
  EXPECT_LE(2 * half.width_px, run.view.page().view_width_px);
}

/// Relative luminance (WCAG 2) of a premultiplied pixel on a ground of this grey, 0…1.
double luminance(std::uint32_t pixel, double ground) {
  const double under = (1 - static_cast<double>(pixel >> 24) / 255) * ground;
  const auto linear = [&](int shift) {
    const double c = std::min(1.0, static_cast<double>(pixel >> shift & 255) / 255 + under);
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * linear(16) + 0.7152 * linear(8) + 0.0722 * linear(0);
}

/// Contrast ratio (WCAG 2) between the lightest and the darkest pixel of a box, on the worse of a black and a white
/// slide.
double contrast(const PixelImage& image, const Box& box) {
  double worst = 21;
  for (const double ground : {0.0, 1.0}) {
    double least = 1;
    double most = 0;
    for (int y = static_cast<int>(box.y); y < box.y + box.height; ++y) {
      for (int x = static_cast<int>(box.x); x < box.x + box.width; ++x) {
        const double light = luminance(image.pixels.at(image.index(x, y)), ground);
        least = std::min(least, light);
        most = std::max(most, light);
      }
    }
    worst = std::min(worst, (most + 0.05) / (least + 0.05));
  }
  return worst;
}

/// The part of an image where it differs from another.
Box changed(const PixelImage& image, const PixelImage& other) {
  Eigen::AlignedBox2d box;
  for (int y = 0; y < image.height_px; ++y) {
    for (int x = 0; x < image.width_px; ++x) {
      if (image.pixels[image.index(x, y)] != other.pixels[other.index(x, y)]) box.extend(Vec2(x, y));
    }
  }
  return {box.min().x(), box.min().y(), box.sizes().x(), box.sizes().y()};
}

constexpr double kTextContrast = 4.5;   // WCAG 2, AA
constexpr double kGraphicContrast = 3;  // of lines

TEST_F(Page, LabelsInTheColumnAreLegibleOnAnySlide) {
  test::OpenedRun run(dir_->path(), settings(Background::transparent));
  run.renderer.advance_to_last();
  const Camera camera = run.camera("section");
  const PageLayout layout = run.view.page();
  const PixelImage view = run.renderer.render(camera, std::nullopt);
  const PixelImage page = annotated_picture(view, layout, camera, column_labels(run, camera), Background::transparent);
  const Box labels = layout.labels();
  const double u = layout.unit;
  const Box bar = layout.legend_bar(1);
  const Box scale = layout.scale_bar(camera).first;
  const Vec2 arrows = layout.directions_px();
  const std::vector<Box> texts{{labels.x, labels.y, labels.width, 30 * u},
                               {labels.x, layout.values_y(), labels.width, 28 * u},
                               {bar.x, bar.y - 60 * u, 100 * u, 25 * u},
                               {bar.x + bar.width + 14 * u, bar.y, 40 * u, bar.height},
                               {arrows.x() - 60 * u, arrows.y() - 90 * u, 120 * u, 30 * u},
                               {scale.x, scale.y - 4, scale.width, scale.height + 4}};
  for (const Box& text : texts) EXPECT_GT(contrast(page, text), kTextContrast) << text.x << ' ' << text.y;
}

TEST_F(Page, MarksOnTheViewAreLegibleOnAnySlide) {
  test::OpenedRun run(dir_->path(), settings(Background::transparent));
  run.renderer.advance_to(40);
  const Camera camera = run.camera("oblique");
  // Off the bone and the tool nothing but the slide is behind a mark.
  const PixelImage empty = blank_page(camera.width_px, camera.height_px, Background::transparent);
  ASSERT_EQ(luminance(empty.pixels.front(), 0), 0);
  PixelImage with_force = empty;
  Labels force;
  force.force = run.captions.arrow(run.run.log().at(40, ""));
  ASSERT_TRUE(force.force);
  draw_marks(with_force, camera, run.view.page().unit, force);
  const Box arrow = changed(with_force, empty);
  ASSERT_GT(arrow.width, 50);
  EXPECT_GT(contrast(with_force, arrow), kTextContrast);

  const Camera face_on = run.camera("glenoid");
  PixelImage outlined = blank_page(face_on.width_px, face_on.height_px, Background::transparent);
  const Labels labels = run.view.labels(face_on, run.view.tool_at(40));
  ASSERT_FALSE(labels.outline_mm.empty());
  draw_marks(outlined, face_on, run.view.page().unit, labels);
  std::vector<double> contrasts;
  for (const Vec3& point : labels.outline_mm) {
    const Vec2 at = face_on.pixel(point);
    contrasts.push_back(contrast(outlined, {at.x() - 8, at.y() - 8, 16, 16}));
  }
  std::ranges::sort(contrasts);
  EXPECT_GT(contrasts[contrasts.size() / 10], kGraphicContrast);
}

}  // namespace
}  // namespace reamsim
