#include "render/pictures/overlay.h"

#include <algorithm>
#include <cmath>

#include "render/pictures/canvas.h"

namespace reamsim {
namespace {

constexpr double kMargin = 28;  // lengths are pixels of a picture 1080 high
constexpr double kText = 23;
constexpr double kMaxArrow = 0.18;  // of the picture's width
constexpr Rgba kForceColor{0.75, 0.10, 0.20, 1};

/// Pixels of this picture per pixel of one 1080 high and at least 1440 wide.
double unit(const Camera& camera) {
  return std::min(camera.height_px / 1080.0, camera.width_px / 1440.0);
}

bool labelled(const Camera& camera) {
  return std::min(camera.width_px, camera.height_px) >= kMinLabelled_px;
}

/// Title and values in the upper left corner. Returns the panel's box.
Box draw_values(const Canvas& canvas, const Camera& camera, const Labels& labels, double left_px) {
  if (labels.title.empty() && labels.values.empty()) return {};
  const double u = unit(camera);
  const double pad = 14 * u;
  const double line = 1.42 * kText * u;
  double name_width = 0;
  double value_width = labels.widest_value.empty() ? 0 : TextLine(canvas, labels.widest_value, kText * u).width;
  for (const auto& [name, value] : labels.values) {
    name_width = std::max(name_width, TextLine(canvas, name, kText * u).width);
    value_width = std::max(value_width, TextLine(canvas, value, kText * u).width);
  }
  const TextLine title(canvas, labels.title, kText * u, true);
  const double inner = std::max(title.width, name_width + 22 * u + value_width);
  const double lines = static_cast<double>(labels.values.size()) + (labels.title.empty()    ? 0
                                                                    : labels.values.empty() ? 1
                                                                                            : 1.15);
  const Box box{left_px + kMargin * u, kMargin * u, inner + 2 * pad, lines * line + 1.4 * pad};
  canvas.fill_panel(box, 8 * u);
  double y = box.y + pad * 0.7;
  canvas.set_color(kTextColor);
  if (!labels.title.empty()) {
    title.draw(box.x + pad, y);
    y += 1.15 * line;
  }
  for (const auto& [name, value] : labels.values) {
    canvas.set_color(kFaintTextColor);
    TextLine(canvas, name, kText * u).draw(box.x + pad, y);
    canvas.set_color(kTextColor);
    const TextLine number(canvas, value, kText * u);
    number.draw(box.x + pad + inner - number.width, y);
    y += line;
  }
  return box;
}

/// A vertical colour bar with ticks, numbers and title. Returns the panel's box.
Box draw_legend(const Canvas& canvas, const Camera& camera, const Legend& legend, const Box& bar) {
  const double u = unit(camera);
  cairo_t* c = canvas.get();
  const TextLine title(canvas, legend.title, 0.87 * kText * u);
  const TextLine unit_text(canvas, legend.unit, 0.87 * kText * u);
  const double right = camera.width_px - kMargin * u;
  const double pad = 14 * u;
  const double width = 146 * u + 2 * pad;
  const double head = title.height + unit_text.height + 12 * u;
  const Box panel{right - width, bar.y - head - pad, width, bar.height + head + 2 * pad + 4 * u};
  canvas.fill_panel(panel, 8 * u);
  canvas.set_color(kTextColor);
  title.draw(right - width + pad, bar.y - head);
  canvas.set_color(kFaintTextColor);
  unit_text.draw(right - width + pad, bar.y - head + title.height);

  const int rows = static_cast<int>(std::ceil(bar.height));
  for (int row = 0; row < rows; ++row) {
    const Eigen::Vector3f color = legend.colors.at(1 - (row + 0.5) / rows);
    cairo_set_source_rgb(c, color.x(), color.y(), color.z());
    // Overlap by one pixel, against seams between rows.
    cairo_rectangle(c, bar.x, bar.y + row, bar.width, std::min(2.0, bar.height - row));
    cairo_fill(c);
  }
  canvas.set_color(kTextColor);
  cairo_set_line_width(c, std::max(1.0, 1.5 * u));
  cairo_rectangle(c, bar.x, bar.y, bar.width, bar.height);
  cairo_stroke(c);
  for (int tick = 0; tick < legend.scale.ticks(); ++tick) {
    const double y = bar.y + bar.height * (1 - tick * legend.scale.step / legend.scale.max);
    canvas.line({bar.x + bar.width, y}, {bar.x + bar.width + 8 * u, y});
    const TextLine number(canvas, legend.scale.label(tick), 0.87 * kText * u);
    number.draw(bar.x + bar.width + 14 * u, y - 0.5 * number.height);
  }
  return panel;
}

Box draw_scale_bar(const Canvas& canvas, const Camera& camera, double fraction) {
  const double u = unit(camera);
  cairo_t* c = canvas.get();
  const auto [bar, length_mm] = scale_bar(camera, fraction);
  Scale exact{length_mm, length_mm};
  const TextLine text(canvas, exact.label(1) + (camera.eye_mm ? " mm at target" : " mm"), kText * u);
  const double width = std::max(bar.width, text.width);
  const Box panel{bar.x - 14 * u, bar.y - text.height - 16 * u, width + 28 * u,
                  text.height + 16 * u + bar.height + 14 * u};
  canvas.fill_panel(panel, 8 * u);
  canvas.set_color(kTextColor);
  cairo_rectangle(c, bar.x, bar.y, bar.width, bar.height);
  cairo_fill(c);
  text.draw(bar.x + 0.5 * (bar.width - text.width), bar.y - text.height - 6 * u);
  return panel;
}

/// Appends a closed polygon to the path.
void trace(const Canvas& canvas, const std::vector<Vec2>& points) {
  for (const Vec2& p : points) cairo_line_to(canvas.get(), p.x(), p.y());
  cairo_close_path(canvas.get());
}

/// An arrow with a light outline, visible on bone and steel. Lengths in pixels.
void stroke_arrow(const Canvas& canvas, const Vec2& from, const Vec2& to, double width, const Rgba& color) {
  cairo_t* c = canvas.get();
  const Vec2 way = (to - from).normalized();
  const Vec2 side(-way.y(), way.x());
  const Vec2 neck = to - std::min(4.2 * width, (to - from).norm()) * way;
  trace(canvas, {from + 0.5 * width * side, neck + 0.5 * width * side, neck + 1.6 * width * side, to,
                 neck - 1.6 * width * side, neck - 0.5 * width * side, from - 0.5 * width * side});
  canvas.set_color({1, 1, 1, 0.9});
  cairo_set_line_join(c, CAIRO_LINE_JOIN_ROUND);
  cairo_set_line_width(c, 0.55 * width);
  cairo_stroke_preserve(c);
  canvas.set_color(color);
  cairo_fill(c);
}

/// The force on the tool, unless it points at the viewer.
void draw_force(const Canvas& canvas, const Camera& camera, const Labels& labels) {
  if (!labels.force) return;
  const double u = unit(camera);
  const Vec2 from = camera.pixel(labels.force->from_mm);
  const double longest_mm = kMaxArrow * camera.width_px * camera.mm_per_px;
  const Vec2 to = camera.pixel(labels.force->from_mm + longest_mm * labels.force->direction);
  if ((to - from).norm() < 14 * u) return;
  stroke_arrow(canvas, from, to, 9 * u, kForceColor);
  const TextLine text(canvas, labels.force->text, kText * u, true);
  const Vec2 way = (to - from).normalized();
  const Vec2 middle = to + (16 * u + 0.5 * (std::abs(way.x()) * text.width + std::abs(way.y()) * text.height)) * way;
  const Box box{middle.x() - 0.5 * text.width - 8 * u, middle.y() - 0.5 * text.height - 3 * u, text.width + 16 * u,
                text.height + 6 * u};
  canvas.fill_panel(box, 5 * u);
  canvas.set_color(kForceColor);
  text.draw(box.x + 8 * u, box.y + 3 * u);
}

/// Arrows towards superior, lateral and anterior, in the lower right corner.
void draw_directions(const Canvas& canvas, const Camera& camera, const Labels& labels) {
  if (labels.directions.empty()) return;
  const double u = unit(camera);
  cairo_t* c = canvas.get();
  const double reach = 62 * u;
  const Vec2 middle(camera.width_px - kMargin * u - 150 * u, camera.height_px - kMargin * u - 100 * u);
  for (const auto& [name, direction] : labels.directions) {
    const Vec3 eye = camera.eye_from_bone.linear() * direction;
    Vec2 way(eye.x(), -eye.y());
    if (way.norm() < 0.35) continue;  // points at the viewer or away
    const Vec2 tip = middle + reach * way;
    way.normalize();
    const Vec2 side(-way.y(), way.x());
    // A light outline, visible on dark bone and on a dark slide behind a transparent background.
    canvas.set_color(kPanelColor);
    cairo_set_line_width(c, 8 * u);
    canvas.line(middle, tip + 5 * u * way);
    canvas.set_color(kTextColor);
    cairo_set_line_width(c, 2.5 * u);
    canvas.line(middle, tip);
    trace(canvas, {tip + 3 * u * way, tip - 11 * u * way + 5 * u * side, tip - 11 * u * way - 5 * u * side});
    cairo_fill(c);
    const TextLine text(canvas, name, 0.80 * kText * u);
    const Vec2 at = tip + (14 * u + 0.5 * std::abs(way.x()) * text.width) * way;
    text.trace(at.x() - 0.5 * text.width, at.y() - 0.5 * text.height);
    canvas.set_color(kPanelColor);
    cairo_set_line_join(c, CAIRO_LINE_JOIN_ROUND);
    cairo_set_line_width(c, 6 * u);
    cairo_stroke_preserve(c);
    canvas.set_color(kTextColor);
    cairo_fill(c);
  }
}

void stroke_outlines(const Canvas& canvas, const Camera& camera, const Labels& labels) {
  const double u = unit(camera);
  cairo_t* c = canvas.get();
  const double dashes[] = {12 * u, 8 * u};
  for (const auto& outline : labels.outlines_mm) {
    std::vector<Vec2> points;
    for (const Vec3& point : outline) points.push_back(camera.pixel(point));
    trace(canvas, points);
    canvas.set_color({1, 1, 1, 0.55});
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

Box legend_box(const Camera& camera, int index, int count) {
  if (!labelled(camera)) return {};
  const double u = unit(camera);
  const double height = (count == 1 ? 420 : 270) * u;
  const double top = kMargin * u + 84 * u + index * (height + 130 * u);
  return {camera.width_px - (kMargin + 160) * u, top, 34 * u, height};
}

std::pair<Box, double> scale_bar(const Camera& camera, double fraction) {
  if (!labelled(camera)) return {{}, 0};
  const double u = unit(camera);
  const double length_mm = round_down(fraction * camera.mm_per_px * camera.width_px);
  const double height = 9 * u;
  const double x = (kMargin + 14) * u;
  return {{x, camera.height_px - (kMargin + 14) * u - height, length_mm / camera.mm_per_px, height}, length_mm};
}

void draw_labels(PixelImage& image, const Camera& camera, const Labels& labels) {
  if (!labelled(camera)) return;
  const Canvas canvas(image);
  stroke_outlines(canvas, camera, labels);
  draw_force(canvas, camera, labels);
  std::vector<Box> panels{draw_values(canvas, camera, labels, 0)};
  const int count = static_cast<int>(labels.legends.size());
  for (int i = 0; i < count; ++i) {
    panels.push_back(
        draw_legend(canvas, camera, labels.legends[static_cast<std::size_t>(i)], legend_box(camera, i, count)));
  }
  panels.push_back(draw_scale_bar(canvas, camera, labels.scale_bar_fraction));
  draw_directions(canvas, camera, labels);
  canvas.finish();
  draw_contour_numbers(image, camera, labels.contours, panels);
}

void draw_outlines(PixelImage& image, const Camera& camera, const Labels& labels) {
  if (labels.outlines_mm.empty()) return;
  const Canvas canvas(image);
  stroke_outlines(canvas, camera, labels);
  canvas.finish();
}

void draw_value_box(PixelImage& image, const Camera& camera, const Labels& labels, double left_px) {
  if (!labelled(camera)) return;
  const Canvas canvas(image);
  draw_values(canvas, camera, labels, left_px);
  canvas.finish();
}

}  // namespace reamsim
