// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/contour_labels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/pictures/canvas.h"
#include "render/surface/color_map.h"

namespace reamsim {
namespace {

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
    for (const Vec2& p : contour.points_px) cairo_line_to(c, p.x(), p.y());
    cairo_close_path(c);
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
