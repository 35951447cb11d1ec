// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/overlay.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <limits>

#include "render/gl/scene.h"
#include "render/pictures/canvas.h"

namespace reamsim {
namespace {

// Lengths in pixels of a picture 1080 high.
constexpr double kColumn = 388;
constexpr double kPageMargin = 24;
constexpr double kTitleLine = 46;
constexpr double kLegendTop = 524;  // of the colour bar, below its title: six values fit above
constexpr double kLegendMax = 420;
constexpr double kSecondLegend = 0.54;  // of the labels' width
constexpr double kBarWidth = 34;
constexpr double kFoot = 266;  // directions and scale bar
constexpr double kScaleBar = 10;
constexpr double kTitle = 27;
constexpr double kValue = 28;
constexpr double kName = 22;     // of values, legends and directions
constexpr double kValueGap = 9;  // between values
constexpr double kReach = 56;    // of the arrows of directions
constexpr Rgba kLineColor{0.78, 0.80, 0.83, 1};
/// Tolerance for rounding, so that 0.1 · 30 counts as 3.
constexpr double kScaleTolerance = 1e-9;

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
  const double line_px = std::max(1.0, 1.5 * u);
  cairo_rectangle(c, bar.x, bar.y, bar.width, bar.height);
  canvas.stroke(kTextColor, line_px);
  for (int tick = 0; tick < legend.scale.ticks(); ++tick) {
    const double y = bar.y + bar.height * (1 - tick * legend.scale.step / legend.scale.max);
    canvas.line({bar.x + bar.width, y}, {bar.x + bar.width + 8 * u, y}, kTextColor, line_px);
    const TextLine number(canvas, legend.scale.label(tick), kName * u);
    number.draw(bar.x + bar.width + 14 * u, y - 0.5 * number.height);
  }
}

void draw_scale_bar(const Canvas& canvas, const PageLayout& layout, const Camera& camera, double fraction) {
  const auto [bar, length_mm] = layout.scale_bar(camera, fraction);
  const Scale exact{length_mm, length_mm};
  const TextLine text(canvas, exact.label(1) + (camera.eye_mm ? " mm at target" : " mm"), kName * layout.unit);
  cairo_rectangle(canvas.get(), bar.x, bar.y, bar.width, bar.height);
  canvas.fill(kTextColor);
  text.draw(bar.x + std::max(0.0, 0.5 * (bar.width - text.width)), bar.y - text.height - 6 * layout.unit);
}

/// Arrows towards superior, lateral and anterior.
void draw_directions(const Canvas& canvas, const PageLayout& layout, const Camera& camera, const Labels& labels) {
  const double u = layout.unit;
  const Vec2 middle = layout.directions_px();
  for (const auto& [name, direction] : labels.directions) {
    const Vec3 eye = camera.eye_from_bone.linear() * direction;
    Vec2 way(eye.x(), -eye.y());
    if (way.norm() < 0.35) continue;  // points at the viewer or away
    const Vec2 tip = middle + kReach * u * way;
    way.normalize();
    const Vec2 side(-way.y(), way.x());
    canvas.line(middle, tip, kTextColor, 2.5 * u);
    canvas.trace({tip + 3 * u * way, tip - 11 * u * way + 5 * u * side, tip - 11 * u * way - 5 * u * side});
    canvas.fill(kTextColor);
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
  const double x = box.x + std::max(1.0, layout.unit);
  canvas.line({x, 0}, {x, box.height}, kLineColor, std::max(1.0, 1.5 * layout.unit));
}

constexpr double kText = 24;
constexpr double kMaxArrow = 0.22;  // of the view's width
constexpr Rgba kForceColor{0.75, 0.10, 0.20, 1};

/// An arrow with a light outline, visible on bone and steel.
void stroke_arrow(const Canvas& canvas, const Vec2& from, const Vec2& to, double width) {
  const Vec2 way = (to - from).normalized();
  const Vec2 side(-way.y(), way.x());
  const Vec2 neck = to - std::min(4.2 * width, (to - from).norm()) * way;
  canvas.trace({from + 0.5 * width * side, neck + 0.5 * width * side, neck + 1.6 * width * side, to,
                neck - 1.6 * width * side, neck - 0.5 * width * side, from - 0.5 * width * side});
  cairo_set_line_join(canvas.get(), CAIRO_LINE_JOIN_ROUND);
  canvas.stroke_halo({1, 1, 1, 0.9}, 0.55 * width);
  canvas.fill(kForceColor);
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
  std::vector<Vec2> points;
  for (const Vec3& point : outline_mm) points.push_back(camera.pixel(point));
  canvas.trace(points);
  canvas.stroke_halo({1, 1, 1, 0.7}, std::max(2.0, 5 * u));
  const double dashes[] = {12 * u, 8 * u};
  cairo_set_dash(canvas.get(), dashes, 2, 0);
  canvas.stroke({0.15, 0.25, 0.40, 1}, std::max(1.0, 2.4 * u));
  cairo_set_dash(canvas.get(), nullptr, 0, 0);
}

constexpr double kTextHeight = 19;
constexpr double kCharWidth = 0.62;  // of the height
constexpr double kLeastRoom = 0.55;  // of the height: the least distance of a number's middle from other lines
constexpr double kWantedRoom = 2;    // of the height: more room is no better
constexpr double kDarkBelow = 0.5;   // luminance of the colours below which a line is light
const Rgba kLightLine{1, 1, 1, kContourOpacity};
const Rgba kDarkLine{0.05, 0.07, 0.10, kContourOpacity};
constexpr Rgba kHalo{1, 1, 1, 0.85};

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

}  // namespace

double picture_unit(int width_px, int height_px) {
  return std::min(height_px / 1080.0, width_px / 1440.0);
}

PageLayout page_layout(int width_px, int height_px) {
  const double unit = picture_unit(width_px, height_px);
  const bool labelled = std::min(width_px, height_px) >= kMinLabelled_px;
  const int column_px = labelled ? static_cast<int>(std::lround(kColumn * unit)) : 0;
  return {width_px, height_px, width_px - column_px, unit};
}

Box PageLayout::labels() const {
  const double margin = kPageMargin * unit;
  return {view_width_px + margin, margin, width_px - view_width_px - 2 * margin, height_px - 2 * margin};
}

double PageLayout::values_y() const {
  return labels().y + kTitleLine * unit;
}

Box PageLayout::legend_bar(int index) const {
  const Box box = labels();
  const double height = std::min(kLegendMax * unit, height_px - (kLegendTop + kFoot) * unit);
  return {box.x + index * kSecondLegend * box.width, kLegendTop * unit, kBarWidth * unit, height};
}

Vec2 PageLayout::directions_px() const {
  const Box box = labels();
  return {box.x + 0.5 * box.width, height_px - 150 * unit};
}

std::pair<Box, double> PageLayout::scale_bar(const Camera& camera, double fraction) const {
  const Box box = labels();
  const double length_mm = round_down(camera.mm_per_px * std::min(fraction * view_width_px, box.width));
  const double height = kScaleBar * unit;
  return {{box.x, box.y + box.height - height, length_mm / camera.mm_per_px, height}, length_mm};
}

double round_down(double value) {
  const double decade = std::pow(10.0, std::floor(std::log10(value) + kScaleTolerance));
  const double lead = value / decade;
  return decade * (lead >= 5 - kScaleTolerance ? 5 : lead >= 2 - kScaleTolerance ? 2 : 1);
}

double round_up(double value) {
  const double below = round_down(value);
  if (below >= value * (1 - kScaleTolerance)) return below;
  const double decade = std::pow(10.0, std::floor(std::log10(below) + kScaleTolerance));
  const double lead = below / decade;
  return decade * (lead < 1.5 ? 2 : lead < 3 ? 5 : 10);
}

int Scale::ticks() const {
  return static_cast<int>(std::floor(max / step + 1e-6)) + 1;
}

std::string Scale::label(int tick) const {
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - kScaleTolerance)), 0, 6);
  return fmt::format("{:.{}f}", tick * step, decimals);
}

Scale scale_up_to(double max) {
  if (!(max > 0) || !std::isfinite(max)) return {1, 0.2};
  const double step = round_up(max / 8);
  return {step * std::ceil(max / step - 1e-6), step};
}

Scale scale_exactly(double max) {
  return {max, round_up(max / 8)};
}

PixelImage blank_page(int width_px, int height_px, Background background) {
  PixelImage page = plain_image(width_px, height_px, background == Background::studio ? kColumnRgb : 0xffffff);
  if (background == Background::transparent) page.pixels.assign(page.pixels.size(), 0);
  return page;
}

PixelImage annotated_picture(PixelImage view, const PageLayout& layout, const Camera& camera, const Labels& labels,
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
  const Eigen::AlignedBox2d view(Vec2(0, 0), Vec2(camera.width_px, camera.height_px));
  std::vector<ContourNumber> out;
  for (std::size_t k = 0; k < contours.size(); ++k) {
    const SeenContour& contour = contours[k];
    const double width = (kCharWidth * static_cast<double>(contour.text.size()) + 0.4) * height;
    const Vec2 half(0.5 * width, 0.5 * height);
    double best = -1;
    Eigen::AlignedBox2d best_box;
    for (std::size_t n = 0; n < contour.points_px.size(); ++n) {
      if (!visible_around(contour, n, width)) continue;
      const Eigen::AlignedBox2d box(contour.points_px[n] - half, contour.points_px[n] + half);
      if (!view.contains(box)) continue;
      if (std::ranges::any_of(out, [&](const ContourNumber& other) { return box.intersects(other.box_px); })) continue;
      const double room = room_at(contour.points_px[n], contours, k);
      if (room < kLeastRoom * height) continue;
      double away = 8 * height;
      for (const ContourNumber& other : out) away = std::min(away, (other.box_px.center() - box.center()).norm());
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
  cairo_set_line_join(canvas.get(), CAIRO_LINE_JOIN_ROUND);
  for (const SeenContour& contour : contours) {
    canvas.trace(contour.points_px);
    canvas.stroke(contour.light ? kLightLine : kDarkLine, std::max(1.0, kContourWidth_px * unit));
  }
  canvas.finish();
}

void draw_contour_numbers(PixelImage& image, const Camera& camera, double unit,
                          const std::vector<SeenContour>& contours) {
  const Canvas canvas(image);
  cairo_set_line_join(canvas.get(), CAIRO_LINE_JOIN_ROUND);
  for (const ContourNumber& number : place_contour_numbers(contours, camera, unit)) {
    const TextLine text(canvas, contours[number.contour].text, kTextHeight * 0.92 * unit);
    const Vec2 middle = number.box_px.center();
    text.trace(middle.x() - 0.5 * text.width, middle.y() - 0.5 * text.height);
    canvas.stroke_halo(kHalo, 5 * unit);
    canvas.fill(kTextColor);
  }
  canvas.finish();
}

}  // namespace reamsim
