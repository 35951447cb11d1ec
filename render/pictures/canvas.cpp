#include "render/pictures/canvas.h"

#include <numbers>

#include "sim/base/error.h"

namespace reamsim {

Canvas::Canvas(PixelImage& image)
    : surface_(cairo_image_surface_create_for_data(reinterpret_cast<unsigned char*>(image.pixels.data()),
                                                   CAIRO_FORMAT_ARGB32, image.width_px, image.height_px,
                                                   4 * image.width_px)),
      cairo_(cairo_create(surface_)) {
  if (cairo_status(cairo_) != CAIRO_STATUS_SUCCESS) {
    const std::string reason = cairo_status_to_string(cairo_status(cairo_));
    release();
    throw RunError("labels cannot be drawn: " + reason);
  }
  cairo_font_options_t* options = cairo_font_options_create();
  cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
  cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
  cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
  cairo_set_font_options(cairo_, options);
  cairo_font_options_destroy(options);
}

Canvas::~Canvas() {
  release();
}

void Canvas::release() {
  cairo_destroy(cairo_);
  cairo_surface_destroy(surface_);
}

void Canvas::fill_panel(const Box& box, double radius) const {
  constexpr double kQuarter = std::numbers::pi / 2;
  cairo_new_sub_path(cairo_);
  cairo_arc(cairo_, box.x + box.width - radius, box.y + radius, radius, -kQuarter, 0);
  cairo_arc(cairo_, box.x + box.width - radius, box.y + box.height - radius, radius, 0, kQuarter);
  cairo_arc(cairo_, box.x + radius, box.y + box.height - radius, radius, kQuarter, 2 * kQuarter);
  cairo_arc(cairo_, box.x + radius, box.y + radius, radius, 2 * kQuarter, 3 * kQuarter);
  cairo_close_path(cairo_);
  ink(kPanelColor);
  cairo_fill(cairo_);
}

void Canvas::finish() const {
  cairo_surface_flush(surface_);
  if (cairo_status(cairo_) != CAIRO_STATUS_SUCCESS) {
    throw RunError(std::string("labels cannot be drawn: ") + cairo_status_to_string(cairo_status(cairo_)));
  }
}

TextLine::TextLine(const Canvas& canvas, const std::string& text, double size_px, bool bold)
    : cairo_(canvas.get()), layout_(pango_cairo_create_layout(canvas.get()), g_object_unref) {
  PangoFontDescription* font = pango_font_description_new();
  pango_font_description_set_family(font, "DejaVu Sans");
  pango_font_description_set_weight(font, bold ? PANGO_WEIGHT_BOLD : PANGO_WEIGHT_NORMAL);
  pango_font_description_set_absolute_size(font, size_px * PANGO_SCALE);
  pango_layout_set_font_description(layout_.get(), font);
  pango_font_description_free(font);
  pango_layout_set_text(layout_.get(), text.c_str(), -1);
  PangoRectangle logical;
  pango_layout_get_extents(layout_.get(), nullptr, &logical);
  width = static_cast<double>(logical.width) / PANGO_SCALE;
  height = static_cast<double>(logical.height) / PANGO_SCALE;
}

void TextLine::draw(double x, double y) const {
  cairo_move_to(cairo_, x, y);
  pango_cairo_show_layout(cairo_, layout_.get());
}

}  // namespace reamsim
