// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/overlay.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/gl/scene.h"
#include "render/pictures/canvas.h"

namespace reamsim {
namespace {

// Lengths in pixels of a picture 1080 high.
constexpr double kTitle = 27;
constexpr double kValue = 28;
constexpr double kName = 22;     // of values, legends and directions
constexpr double kValueGap = 9;  // between values
constexpr double kReach = 56;    // of the arrows of directions
constexpr Rgba kLineColor{0.78, 0.80, 0.83, 1};

/// Draws title and values, one below the other.
void draw_values(const Canvas& canvas, const PageLayout& layout, const Labels& labels) {
  const double u = layout.unit;
  const Box box = layout.labels();
  double y = box.y;
  if (!labels.title.empty()) {
    const TextLine title(canvas, labels.title, kTitle * u, true, box.width);
    title.draw(box.x, box.y);
    y = std::max(layout.values_y(), box.y + title.height + kValueGap * u);
  }
  for (const auto& [name, value] : labels.values) {
    const TextLine name_text(canvas, name, kName * u);
    const TextLine number(canvas, value, kValue * u);
    name_text.draw(box.x, y, kFaintTextColor);
    number.draw(box.x, y + name_text.height);
    y += name_text.height + number.height + kValueGap * u;
  }
}

/// A vertical colour bar with ticks and numbers, title and unit above it.
void draw_legend(const Canvas& canvas, double u, const Legend& legend, const Box& bar) {
  cairo_t* c = canvas.get();
  const TextLine title(canvas, legend.title, 0.9 * kName * u);
  const TextLine unit_text(canvas, legend.unit, 0.9 * kName * u);
  title.draw(bar.x, bar.y - title.height - unit_text.height - 10 * u);
  unit_text.draw(bar.x, bar.y - unit_text.height - 10 * u, kFaintTextColor);
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
    const TextLine number(canvas, legend.scale.label(tick), kName * u);
    number.draw(bar.x + bar.width + 14 * u, y - 0.5 * number.height);
  }
}

void draw_scale_bar(const Canvas& canvas, const PageLayout& layout, const Camera& camera, double fraction) {
  const auto [bar, length_mm] = layout.scale_bar(camera, fraction);
  const Scale exact{length_mm, length_mm};
  const TextLine text(canvas, exact.label(1) + (camera.eye_mm ? " mm at target" : " mm"), kName * layout.unit);
  canvas.set_color(kTextColor);
  cairo_rectangle(canvas.get(), bar.x, bar.y, bar.width, bar.height);
  cairo_fill(canvas.get());
  text.draw(bar.x + std::max(0.0, 0.5 * (bar.width - text.width)), bar.y - text.height - 6 * layout.unit);
}

/// Arrows towards superior, lateral and anterior.
void draw_directions(const Canvas& canvas, const PageLayout& layout, const Camera& camera, const Labels& labels) {
  const double u = layout.unit;
  cairo_t* c = canvas.get();
  canvas.set_color(kTextColor);
  cairo_set_line_width(c, 2.5 * u);
  const Vec2 middle = layout.directions_px();
  for (const auto& [name, direction] : labels.directions) {
    const Vec3 eye = camera.eye_from_bone.linear() * direction;
    Vec2 way(eye.x(), -eye.y());
    if (way.norm() < 0.35) continue;  // points at the viewer or away
    const Vec2 tip = middle + kReach * u * way;
    way.normalize();
    const Vec2 side(-way.y(), way.x());
    canvas.line(middle, tip);
    canvas.trace({tip + 3 * u * way, tip - 11 * u * way + 5 * u * side, tip - 11 * u * way - 5 * u * side});
    cairo_fill(c);
    const TextLine text(canvas, name, 0.9 * kName * u);
    const Vec2 at = tip + (14 * u + 0.5 * std::abs(way.x()) * text.width) * way;
    text.draw(at.x() - 0.5 * text.width, at.y() - 0.5 * text.height);
  }
}

/// The column's ground: a plate on a transparent background, for legibility; a line beside the view on a white one.
void draw_ground(const Canvas& canvas, const PageLayout& layout, Background background) {
  const double column = layout.width_px - layout.view_width_px;
  const Box box{static_cast<double>(layout.view_width_px), 0, column, static_cast<double>(layout.height_px)};
  if (background == Background::transparent) canvas.fill_panel(box, 12 * layout.unit, kPlateColor);
  if (background != Background::white) return;
  canvas.set_color(kLineColor);
  cairo_set_line_width(canvas.get(), std::max(1.0, 1.5 * layout.unit));
  const double x = box.x + std::max(1.0, layout.unit);
  canvas.line({x, 0}, {x, box.height});
}

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
  text.draw(box.x + 8 * u, box.y + 3 * u, kForceColor);
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

void stroke_outline(const Canvas& canvas, const Camera& camera, double u, const std::vector<Vec3>& outline_mm) {
  if (outline_mm.empty()) return;
  cairo_t* c = canvas.get();
  std::vector<Vec2> points;
  for (const Vec3& point : outline_mm) points.push_back(camera.pixel(point));
  canvas.trace(points);
  canvas.set_color({1, 1, 1, 0.7});
  cairo_set_line_width(c, std::max(2.0, 5 * u));
  cairo_stroke_preserve(c);
  canvas.set_color({0.15, 0.25, 0.40, 1});
  cairo_set_line_width(c, std::max(1.0, 2.4 * u));
  const double dashes[] = {12 * u, 8 * u};
  cairo_set_dash(c, dashes, 2, 0);
  cairo_stroke(c);
  cairo_set_dash(c, nullptr, 0, 0);
}

constexpr double kTextHeight = 19;   // pixels of a picture 1080 high
constexpr double kCharWidth = 0.62;  // of the height
constexpr double kLeastRoom = 0.55;  // of the height: the least distance of a number's middle from other lines
constexpr double kWantedRoom = 2;    // of the height: more room is no better
constexpr double kDarkBelow = 0.5;   // luminance of the colours below which a line is light
const Rgba kLightLine{1, 1, 1, kContourOpacity};
const Rgba kDarkLine{0.05, 0.07, 0.10, kContourOpacity};
constexpr Rgba kHalo{1, 1, 1, 0.85};

Box around(const Vec2& middle, double width, double height) {
  return {middle.x() - 0.5 * width, middle.y() - 0.5 * height, width, height};
}

bool overlap(const Box& a, const Box& b) {
  return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}

Vec2 middle_of(const Box& box) {
  return {box.x + 0.5 * box.width, box.y + 0.5 * box.height};
}

/// Is a contour visible as far as its number reaches to both sides of one of its points?
bool visible_around(const SeenContour& contour, std::size_t point, double reach_px) {
  const std::size_t count = contour.points_px.size();
  for (const std::size_t step : {std::size_t{1}, count - 1}) {
    for (std::size_t n = point; (contour.points_px[n] - contour.points_px[point]).norm() < reach_px;) {
      if (!contour.visible[n]) return false;
      n = (n + step) % count;
      if (n == point) break;
    }
  }
  return true;
}

/// Distance of a place on one contour from the others.
double room_at(const Vec2& place, const std::vector<SeenContour>& contours, std::size_t own) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < contours.size(); ++k) {
    if (k == own) continue;
    for (std::size_t n = 0; n < contours[k].points_px.size(); n += 2) {
      least = std::min(least, (contours[k].points_px[n] - place).squaredNorm());
    }
  }
  return std::sqrt(least);
}

bool inside(const Box& box, const Camera& camera) {
  return box.x >= 0 && box.y >= 0 && box.x + box.width <= camera.width_px && box.y + box.height <= camera.height_px;
}

}  // namespace

PixelImage blank_page(int width_px, int height_px, Background background) {
  PixelImage page = plain_image(width_px, height_px, background == Background::studio ? kColumnRgb : 0xffffff);
  if (background == Background::transparent) page.pixels.assign(page.pixels.size(), 0);
  return page;
}

PixelImage labelled_page(PixelImage view, const PageLayout& layout, const Camera& camera, const Labels& labels,
                         Background background) {
  if (!layout.labelled()) return view;
  draw_marks(view, camera, layout.unit, labels);
  PixelImage page = blank_page(layout.width_px, layout.height_px, background);
  page.paste(view, 0, 0);
  const Canvas canvas(page);
  draw_ground(canvas, layout, background);
  draw_values(canvas, layout, labels);
  const int count = static_cast<int>(labels.legends.size());
  for (int i = 0; i < count; ++i) {
    draw_legend(canvas, layout.unit, labels.legends[static_cast<std::size_t>(i)], layout.legend_bar(i));
  }
  draw_directions(canvas, layout, camera, labels);
  draw_scale_bar(canvas, layout, camera, labels.scale_bar_fraction);
  canvas.finish();
  return page;
}

void draw_marks(PixelImage& view, const Camera& camera, double unit, const Labels& labels) {
  const Canvas canvas(view);
  stroke_outline(canvas, camera, unit, labels.outline_mm);
  if (labels.force) draw_force(canvas, camera, unit, *labels.force);
  canvas.finish();
  draw_contour_numbers(view, camera, unit, labels.contours);
}

SeenContour contour_style(double value, const Scale& scale) {
  const Eigen::Vector3f color = depth_colors().at(value / scale.max);
  const double luminance = color.dot(Eigen::Vector3f(0.2126F, 0.7152F, 0.0722F));
  return {scale.label(static_cast<int>(std::lround(value / scale.step))), luminance < kDarkBelow, {}, {}};
}

std::vector<ContourNumber> place_contour_numbers(const std::vector<SeenContour>& contours, const Camera& camera,
                                                 double unit) {
  const double height = kTextHeight * unit;
  std::vector<ContourNumber> out;
  for (std::size_t k = 0; k < contours.size(); ++k) {
    const SeenContour& contour = contours[k];
    const double width = (kCharWidth * static_cast<double>(contour.text.size()) + 0.4) * height;
    double best = -1;
    Box best_box;
    for (std::size_t n = 0; n < contour.points_px.size(); ++n) {
      if (!visible_around(contour, n, width)) continue;
      const Box box = around(contour.points_px[n], width, height);
      if (!inside(box, camera)) continue;
      if (std::ranges::any_of(out, [&](const ContourNumber& other) { return overlap(box, other.box); })) continue;
      const double room = room_at(contour.points_px[n], contours, k);
      if (room < kLeastRoom * height) continue;
      double away = 8 * height;
      for (const ContourNumber& other : out) away = std::min(away, (middle_of(other.box) - middle_of(box)).norm());
      const double score = std::min(room, kWantedRoom * height) + 0.25 * away;
      if (score <= best) continue;
      best = score;
      best_box = box;
    }
    if (best >= 0) out.push_back({k, best_box});
  }
  return out;
}

void draw_contours(PixelImage& image, double unit, const std::vector<SeenContour>& contours) {
  const Canvas canvas(image);
  cairo_t* c = canvas.get();
  cairo_set_line_width(c, std::max(1.0, kContourWidth_px * unit));
  cairo_set_line_join(c, CAIRO_LINE_JOIN_ROUND);
  for (const SeenContour& contour : contours) {
    canvas.set_color(contour.light ? kLightLine : kDarkLine);
    canvas.trace(contour.points_px);
    cairo_stroke(c);
  }
  canvas.finish();
}

void draw_contour_numbers(PixelImage& image, const Camera& camera, double unit,
                          const std::vector<SeenContour>& contours) {
  const Canvas canvas(image);
  cairo_t* c = canvas.get();
  for (const ContourNumber& number : place_contour_numbers(contours, camera, unit)) {
    const TextLine text(canvas, contours[number.contour].text, kTextHeight * 0.92 * unit);
    const Vec2 middle = middle_of(number.box);
    text.trace(middle.x() - 0.5 * text.width, middle.y() - 0.5 * text.height);
    canvas.set_color(kHalo);
    cairo_set_line_join(c, CAIRO_LINE_JOIN_ROUND);
    cairo_set_line_width(c, 5 * unit);
    cairo_stroke_preserve(c);
    canvas.set_color(kTextColor);
    cairo_fill(c);
  }
  canvas.finish();
}

}  // namespace reamsim
