// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/figures.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>

#include "render/pictures/canvas.h"
#include "render/pictures/contour_lines.h"
#include "sim/base/parallel.h"

namespace reamsim {
namespace {

constexpr int kSegmentationWidth_px = 1920, kMaxHeight_px = 1400;
constexpr int kGap_px = 24, kHead_px = 44, kFoot_px = 64;
constexpr double kText_px = 20, kOutline_px = 1.6;
/// The bone window of radiology: black at its lower end, white at its upper end.
constexpr double kBlack_hu = -450, kWhite_hu = 1050;
constexpr std::uint32_t kPaperColor = 0xf7f7f9;
constexpr Rgba kOutlineColor{0.90, 0.62, 0.0, 1};  // Okabe and Ito's orange
constexpr Rgba kMarkColor{0.34, 0.71, 0.91, 1};    // and their sky blue
constexpr Rgba kLetterColor{1, 1, 1, 0.9};

Vec2 size_mm(const ScanPlane& plane) {
  return {plane.columns * plane.spacing_mm.x(), plane.rows * plane.spacing_mm.y()};
}

/// One plane and its place in the picture.
struct Panel {
  const ScanPlane& plane;
  double px_per_mm;
  int x, y, width, height;

  /// Pixel position of the centre of a column and row.
  [[nodiscard]] Vec2 px(const Vec2& voxel) const {
    return {x + (voxel.x() + 0.5) * plane.spacing_mm.x() * px_per_mm,
            y + (voxel.y() + 0.5) * plane.spacing_mm.y() * px_per_mm};
  }
};

std::vector<Panel> panels_of(const std::vector<ScanPlane>& planes) {
  double all_mm = 0, tallest_mm = 0;
  for (const ScanPlane& plane : planes) {
    all_mm += size_mm(plane).x();
    tallest_mm = std::max(tallest_mm, size_mm(plane).y());
  }
  const double room_px = kSegmentationWidth_px - kGap_px * (static_cast<double>(planes.size()) + 1);
  const double scale = std::min(room_px / all_mm, (kMaxHeight_px - kHead_px - kFoot_px) / tallest_mm);
  std::vector<Panel> out;
  double x = kGap_px + 0.5 * (room_px - scale * all_mm);
  for (const ScanPlane& plane : planes) {
    const Vec2 size_px = scale * size_mm(plane);
    const int width = std::max(1, static_cast<int>(size_px.x())), height = std::max(1, static_cast<int>(size_px.y()));
    out.push_back({plane, scale, static_cast<int>(x), kHead_px, width, height});
    x += width + kGap_px;
  }
  return out;
}

void paint(const Panel& panel, PixelImage& image) {
  const ScanPlane& plane = panel.plane;
  const RasterField hu{{plane.columns, plane.rows}, Vec2::Zero(), 1, {plane.hu.begin(), plane.hu.end()}};
  parallel_items(static_cast<std::size_t>(panel.height), [&](std::size_t line) {
    const double row = (static_cast<double>(line) + 0.5) / (panel.px_per_mm * plane.spacing_mm.y()) - 0.5;
    const std::size_t start = (static_cast<std::size_t>(panel.y) + line) * static_cast<std::size_t>(image.width_px);
    for (int i = 0; i < panel.width; ++i) {
      const double column = (i + 0.5) / (panel.px_per_mm * plane.spacing_mm.x()) - 0.5;
      const double bright = (hu.at({column, row}) - kBlack_hu) / (kWhite_hu - kBlack_hu);
      const auto gray = static_cast<std::uint32_t>(std::lround(255 * std::clamp(bright, 0.0, 1.0)));
      image.pixels[start + static_cast<std::size_t>(panel.x + i)] = 0xff000000U | gray << 16 | gray << 8 | gray;
    }
  });
}

/// The zero contour of the field in the square between four voxel centres (marching squares).
void outline_square(const Canvas& canvas, const Panel& panel, int column, int row) {
  const ScanPlane& plane = panel.plane;
  const std::array<Vec2, 4> corner{Vec2(column, row), Vec2(column + 1, row), Vec2(column + 1, row + 1),
                                   Vec2(column, row + 1)};
  const std::array<double, 4> value{plane.field[plane.at(column, row)], plane.field[plane.at(column + 1, row)],
                                    plane.field[plane.at(column + 1, row + 1)], plane.field[plane.at(column, row + 1)]};
  std::array<Vec2, 4> crossing;
  std::size_t crossings = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t next = (i + 1) % 4;
    if ((value[i] > 0) == (value[next] > 0)) continue;
    const double fraction = value[i] / (value[i] - value[next]);
    crossing[crossings++] = corner[i] + fraction * (corner[next] - corner[i]);
  }
  // With four crossings the sign of the mean decides which corners are connected.
  const double middle = value[0] + value[1] + value[2] + value[3];
  const std::size_t shift = crossings == 4 && (middle > 0) == (value[0] > 0) ? 1 : 0;
  for (std::size_t i = 0; i + 1 < crossings; i += 2) {
    const Vec2 from = panel.px(crossing[(i + shift) % crossings]), to = panel.px(crossing[(i + shift + 1) % crossings]);
    cairo_move_to(canvas.get(), from.x(), from.y());
    cairo_line_to(canvas.get(), to.x(), to.y());
  }
}

void draw_outline(const Canvas& canvas, const Panel& panel) {
  cairo_set_line_cap(canvas.get(), CAIRO_LINE_CAP_ROUND);
  for (int row = 0; row + 1 < panel.plane.rows; ++row) {
    for (int column = 0; column + 1 < panel.plane.columns; ++column) outline_square(canvas, panel, column, row);
  }
  canvas.stroke(kOutlineColor, kOutline_px);
}

/// A ring about the common point of the planes.
void draw_ring(const Canvas& canvas, const Panel& panel) {
  constexpr double kRadius_px = 7;
  const Vec2 middle = panel.px(panel.plane.through);
  cairo_arc(canvas.get(), middle.x(), middle.y(), kRadius_px, 0, 2 * M_PI);
  canvas.stroke(kMarkColor, 2.5);
}

void draw_letters(const Canvas& canvas, const Panel& panel) {
  TextLine(canvas, panel.plane.name, kText_px, true).draw(panel.x, panel.y - 32);
  const TextLine left(canvas, panel.plane.left, kText_px), right(canvas, panel.plane.right, kText_px);
  const TextLine top(canvas, panel.plane.top, kText_px), bottom(canvas, panel.plane.bottom, kText_px);
  const double middle_x = panel.x + 0.5 * panel.width, middle_y = panel.y + 0.5 * (panel.height - left.height);
  left.draw(panel.x + 6, middle_y, kLetterColor);
  right.draw(panel.x + panel.width - right.width - 6, middle_y, kLetterColor);
  top.draw(middle_x - 0.5 * top.width, panel.y + 4, kLetterColor);
  bottom.draw(middle_x - 0.5 * bottom.width, panel.y + panel.height - bottom.height - 4, kLetterColor);
}

std::string legend_of(const Segmentation& segmentation) {
  const Vec3& p = segmentation.planes_through_mm;
  return fmt::format("outline: segmented bone ({}); ring: {}, LPS ({:.1f}, {:.1f}, {:.1f}) mm",
                     segmentation.method == "label_map" ? "label map" : "threshold",
                     segmentation.by_seed ? "the seed" : "where the planes meet", p.x(), p.y(), p.z());
}

void draw_foot(const Canvas& canvas, const Panel& panel, const std::string& legend, int height_px) {
  const double bar_mm = round_down(200 / panel.px_per_mm), bar_px = bar_mm * panel.px_per_mm;
  const double y = height_px - 0.5 * kFoot_px;
  cairo_rectangle(canvas.get(), kGap_px, y, bar_px, 4);
  canvas.fill(kTextColor);
  const TextLine length(canvas, fmt::format("{:g} mm", bar_mm), kText_px);
  length.draw(kGap_px + bar_px + 12, y + 2 - 0.5 * length.height);
  const TextLine text_line(canvas, legend, kText_px);
  text_line.draw(kSegmentationWidth_px - kGap_px - text_line.width, y + 2 - 0.5 * text_line.height);
}

}  // namespace

void write_segmentation_picture(const std::string& dir, const Segmentation& segmentation) {
  if (segmentation.planes.empty()) return;
  const std::vector<Panel> panels = panels_of(segmentation.planes);
  const int tallest = std::ranges::max_element(panels, {}, &Panel::height)->height;
  PixelImage image = plain_image(kSegmentationWidth_px, kHead_px + tallest + kFoot_px, kPaperColor);
  for (const Panel& panel : panels) paint(panel, image);
  const Canvas canvas(image);
  for (const Panel& panel : panels) {
    draw_outline(canvas, panel);
    draw_ring(canvas, panel);
    draw_letters(canvas, panel);
  }
  draw_foot(canvas, panels.front(), legend_of(segmentation), image.height_px);
  canvas.finish();
  write_png(dir + "/segmentation.png", image);
}

}  // namespace reamsim
