#pragma once

#include <cairo.h>
#include <pango/pangocairo.h>

#include <memory>
#include <string>

#include "render/gl/pixel_image.h"

namespace reamsim {

/// A colour of what is drawn over a picture, 0…1.
struct Rgba {
  double r, g, b, a;
};
constexpr Rgba kTextColor{0.10, 0.12, 0.15, 1};
constexpr Rgba kFaintTextColor{0.28, 0.32, 0.37, 1};
constexpr Rgba kPanelColor{1, 1, 1, 0.80};

/// A drawing surface over a picture's pixels.
class Canvas {
 public:
  /// `image` outlives the canvas. Throws RunError.
  explicit Canvas(PixelImage& image);
  ~Canvas();
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  [[nodiscard]] cairo_t* get() const { return cairo_; }
  [[nodiscard]] cairo_surface_t* surface() const { return surface_; }
  void set_color(const Rgba& color) const { cairo_set_source_rgba(cairo_, color.r, color.g, color.b, color.a); }
  /// A half-transparent sheet with round corners, to write on.
  void fill_panel(const Box& box, double radius) const;
  /// Puts what was drawn into the pixels. Throws RunError when drawing failed.
  void finish() const;

 private:
  void release();

  cairo_surface_t* surface_;
  cairo_t* cairo_;
};

/// One line of text, measured and ready to be drawn.
class TextLine {
 public:
  TextLine(const Canvas& canvas, const std::string& text, double size_px, bool bold = false);

  /// With its upper left corner at (x, y).
  void draw(double x, double y) const;

  double width = 0;
  double height = 0;

 private:
  cairo_t* cairo_;
  std::unique_ptr<PangoLayout, void (*)(gpointer)> layout_;
};

}  // namespace reamsim
