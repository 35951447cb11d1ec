// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/canvas.h"

#include <numbers>

#include "sim/base/error.h"

namespace reamsim {

Canvas::Canvas(PixelImage& image)
    : surface_(
          cairo_image_surface_create_for_data(reinterpret_cast<unsigned char*>(image.pixels.data()),
                                              CAIRO_FORMAT_ARGB32, image.width_px, image.height_px, 4 * image.width_px),
          cairo_surface_destroy),
      cairo_(cairo_create(surface_.get()), cairo_destroy) {
  check();
  cairo_font_options_t* options = cairo_font_options_create();
  cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
  cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
  cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
  cairo_set_font_options(get(), options);
  cairo_font_options_destroy(options);
}

void Canvas::fill_panel(const Box& box, double radius, const Rgba& color) const {
  constexpr double kQuarter = std::numbers::pi / 2;
  cairo_new_sub_path(get());
  cairo_arc(get(), box.x + box.width - radius, box.y + radius, radius, -kQuarter, 0);
  cairo_arc(get(), box.x + box.width - radius, box.y + box.height - radius, radius, 0, kQuarter);
  cairo_arc(get(), box.x + radius, box.y + box.height - radius, radius, kQuarter, 2 * kQuarter);
  cairo_arc(get(), box.x + radius, box.y + radius, radius, 2 * kQuarter, 3 * kQuarter);
  cairo_close_path(get());
  fill(color);
}

void Canvas::fill(const Rgba& color) const {
  set_color(color);
  cairo_fill(get());
}

void Canvas::stroke_halo(const Rgba& color, double width_px) const {
  set_color(color);
  cairo_set_line_width(get(), width_px);
  cairo_stroke_preserve(get());
}

void Canvas::stroke(const Rgba& color, double width_px) const {
  stroke_halo(color, width_px);
  cairo_new_path(get());
}

void Canvas::check() const {
  const cairo_status_t status = cairo_status(get());
  if (status == CAIRO_STATUS_SUCCESS) return;
  throw RunError(std::string("labels cannot be drawn: ") + cairo_status_to_string(status));
}

void Canvas::line(const Vec2& from, const Vec2& to, const Rgba& color, double width_px) const {
  cairo_move_to(get(), from.x(), from.y());
  cairo_line_to(get(), to.x(), to.y());
  stroke(color, width_px);
}

void Canvas::trace(const std::vector<Vec2>& points) const {
  cairo_new_sub_path(get());
  for (const Vec2& p : points) cairo_line_to(get(), p.x(), p.y());
  cairo_close_path(get());
}

void Canvas::finish() const {
  cairo_surface_flush(surface_.get());
  check();
}

PixelImage scaled_middle(cairo_surface_t* picture, int width_px, int height_px) {
  const double width = cairo_image_surface_get_width(picture), height = cairo_image_surface_get_height(picture);
  const double scale = std::max(width_px / width, height_px / height);
  PixelImage out = plain_image(width_px, height_px, 0xffffff);
  const Canvas canvas(out);
  cairo_t* pen = canvas.get();
  cairo_translate(pen, 0.5 * width_px, 0.5 * height_px);
  cairo_scale(pen, scale, scale);
  cairo_set_source_surface(pen, picture, -0.5 * width, -0.5 * height);
  cairo_pattern_set_filter(cairo_get_source(pen), CAIRO_FILTER_GOOD);
  cairo_pattern_set_extend(cairo_get_source(pen), CAIRO_EXTEND_PAD);
  cairo_paint(pen);
  // Without memory Cairo only sets the status.
  if (cairo_status(pen) == CAIRO_STATUS_NO_MEMORY) throw std::bad_alloc();
  canvas.finish();
  return out;
}

TextLine::TextLine(const Canvas& canvas, const std::string& text, double size_px, bool bold, double wrap_px)
    : cairo_(canvas.get()), layout_(pango_cairo_create_layout(canvas.get()), g_object_unref) {
  PangoFontDescription* font = pango_font_description_new();
  pango_font_description_set_family(font, "DejaVu Sans");
  pango_font_description_set_weight(font, bold ? PANGO_WEIGHT_BOLD : PANGO_WEIGHT_NORMAL);
  pango_font_description_set_absolute_size(font, size_px * PANGO_SCALE);
  pango_layout_set_font_description(layout_.get(), font);
  pango_font_description_free(font);
  if (wrap_px > 0) pango_layout_set_width(layout_.get(), static_cast<int>(wrap_px * PANGO_SCALE));
  pango_layout_set_text(layout_.get(), text.c_str(), -1);
  PangoRectangle logical;
  pango_layout_get_extents(layout_.get(), nullptr, &logical);
  width = static_cast<double>(logical.width) / PANGO_SCALE;
  height = static_cast<double>(logical.height) / PANGO_SCALE;
}

void TextLine::draw(double x, double y, const Rgba& color) const {
  cairo_set_source_rgba(cairo_, color.r, color.g, color.b, color.a);
  cairo_move_to(cairo_, x, y);
  pango_cairo_show_layout(cairo_, layout_.get());
}

void TextLine::trace(double x, double y) const {
  cairo_new_path(cairo_);
  cairo_move_to(cairo_, x, y);
  pango_cairo_layout_path(cairo_, layout_.get());
}

}  // namespace reamsim
