// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>

#include "render/pictures/canvas.h"
#include "render/pictures/overlay.h"

namespace reamsim {
namespace {

constexpr double kText = 24;        // pixels of a picture 1080 high, as all lengths
constexpr double kMaxArrow = 0.22;  // of the view's width
constexpr Rgba kForceColor{0.75, 0.10, 0.20, 1};

/// An arrow with a light outline, visible on bone and steel. Lengths in pixels.
void stroke_arrow(const Canvas& canvas, const Vec2& from, const Vec2& to, double width) {
  cairo_t* c = canvas.get();
  const Vec2 way = (to - from).normalized();
  const Vec2 side(-way.y(), way.x());
  const Vec2 neck = to - std::min(4.2 * width, (to - from).norm()) * way;
  canvas.trace({from + 0.5 * width * side, neck + 0.5 * width * side, neck + 1.6 * width * side, to,
                neck - 1.6 * width * side, neck - 0.5 * width * side, from - 0.5 * width * side});
  canvas.set_color({1, 1, 1, 0.9});
  cairo_set_line_join(c, CAIRO_LINE_JOIN_ROUND);
  cairo_set_line_width(c, 0.55 * width);
  cairo_stroke_preserve(c);
  canvas.set_color(kForceColor);
  cairo_fill(c);
}

/// The text of a force beyond the tip of its arrow, within the view.
void draw_force_text(const Canvas& canvas, const Camera& camera, double u, const std::string& force, const Vec2& tip,
                     const Vec2& way) {
  const TextLine text(canvas, force, kText * u, true);
  const Vec2 middle = tip + (16 * u + 0.5 * (std::abs(way.x()) * text.width + std::abs(way.y()) * text.height)) * way;
  Box box{middle.x() - 0.5 * text.width - 8 * u, middle.y() - 0.5 * text.height - 3 * u, text.width + 16 * u,
          text.height + 6 * u};
  box.x = std::max(0.0, std::min(box.x, camera.width_px - box.width));
  box.y = std::max(0.0, std::min(box.y, camera.height_px - box.height));
  canvas.fill_panel(box, 5 * u, kPlateColor);
  canvas.set_color(kForceColor);
  text.draw(box.x + 8 * u, box.y + 3 * u);
}

/// The force on the tool, unless it points at the viewer.
void draw_force(const Canvas& canvas, const Camera& camera, double u, const ForceArrow& force) {
  const Vec2 from = camera.pixel(force.from_mm);
  const double longest_mm = kMaxArrow * camera.width_px * camera.mm_per_px;
  const Vec2 to = camera.pixel(force.from_mm + longest_mm * force.direction);
  if ((to - from).norm() < 14 * u) return;
  stroke_arrow(canvas, from, to, 9 * u);
  draw_force_text(canvas, camera, u, force.text, to, (to - from).normalized());
}

void stroke_outlines(const Canvas& canvas, const Camera& camera, double u, const Labels& labels) {
  cairo_t* c = canvas.get();
  const double dashes[] = {12 * u, 8 * u};
  for (const auto& outline : labels.outlines_mm) {
    std::vector<Vec2> points;
    for (const Vec3& point : outline) points.push_back(camera.pixel(point));
    canvas.trace(points);
    canvas.set_color({1, 1, 1, 0.7});
    cairo_set_line_width(c, std::max(2.0, 5 * u));
    cairo_stroke_preserve(c);
    canvas.set_color({0.15, 0.25, 0.40, 1});
    cairo_set_line_width(c, std::max(1.0, 2.4 * u));
    cairo_set_dash(c, dashes, 2, 0);
    cairo_stroke(c);
    cairo_set_dash(c, nullptr, 0, 0);
  }
}

}  // namespace

void draw_marks(PixelImage& view, const Camera& camera, double unit, const Labels& labels) {
  const Canvas canvas(view);
  stroke_outlines(canvas, camera, unit, labels);
  if (labels.force) draw_force(canvas, camera, unit, *labels.force);
  canvas.finish();
  draw_contour_numbers(view, camera, unit, labels.contours);
}

}  // namespace reamsim
