// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cairo.h>
#include <pango/pangocairo.h>

#include <memory>
#include <string>
#include <vector>

#include "render/gl/camera.h"
#include "sim/base/geometry.h"

namespace reamsim {

/// A colour with opacity, 0…1.
struct Rgba {
  double r, g, b, a;
};
constexpr Rgba kTextColor{0.10, 0.12, 0.15, 1};
constexpr Rgba kFaintTextColor{0.28, 0.32, 0.37, 1};
constexpr Rgba kPanelColor{1, 1, 1, 0.80};
constexpr Rgba kPlateColor{1, 1, 1, 1};
/// The ground of columns of labels and of plots beside pictures.
constexpr std::uint32_t kColumnRgb = 0xfbfbfc;

/// A drawing surface over a picture's pixels.
class Canvas {
 public:
  /// `image` outlives the canvas. Throws RunError.
  explicit Canvas(PixelImage& image);

  [[nodiscard]] cairo_t* get() const { return cairo_.get(); }
  [[nodiscard]] cairo_surface_t* surface() const { return surface_.get(); }
  void set_color(const Rgba& color) const { cairo_set_source_rgba(get(), color.r, color.g, color.b, color.a); }
  /// Fills a panel with round corners, as a background for text.
  void fill_panel(const Box& box, double radius, const Rgba& color = kPanelColor) const;
  /// Fill or stroke the path, and keep colour and width.
  void fill(const Rgba& color) const;
  void stroke(const Rgba& color, double width_px) const;
  /// Strokes the path before it is drawn again, narrower or filled.
  void stroke_halo(const Rgba& color, double width_px) const;
  void line(const Vec2& from, const Vec2& to, const Rgba& color, double width_px) const;
  /// Appends a closed polygon of its own to the path.
  void trace(const std::vector<Vec2>& points) const;
  /// Flushes the drawing into the pixels. Throws RunError when drawing failed.
  void finish() const;

 private:
  void check() const;

  std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> surface_;
  std::unique_ptr<cairo_t, decltype(&cairo_destroy)> cairo_;
};

/// A picture, cropped about its middle to the proportions of `width_px` × `height_px` and scaled to that size, on
/// white. Throws RunError and bad_alloc.
PixelImage scaled_middle(cairo_surface_t* picture, int width_px, int height_px);

/// Text with its measured size; one line unless it is wrapped.
class TextLine {
 public:
  /// `wrap_px`: width of lines; 0: one line.
  TextLine(const Canvas& canvas, const std::string& text, double size_px, bool bold = false, double wrap_px = 0);

  /// Draws it with its upper left corner at (x, y).
  void draw(double x, double y, const Rgba& color = kTextColor) const;
  /// Appends its outline to the path, in the same place.
  void trace(double x, double y) const;

  double width = 0, height = 0;

 private:
  cairo_t* cairo_;
  std::unique_ptr<PangoLayout, void (*)(gpointer)> layout_;
};

}  // namespace reamsim
