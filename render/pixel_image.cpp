#include "render/pixel_image.h"

#include <algorithm>
#include <cstddef>

#include "render/canvas.h"
#include "sim/base/error.h"

namespace reamsim {

void PixelImage::paste(const PixelImage& part, int x, int y) {
  const int columns = std::min(part.width_px, width_px - x);
  const int rows = std::min(part.height_px, height_px - y);
  if (columns <= 0) return;
  for (int row = 0; row < rows; ++row) {
    const auto from = part.pixels.begin() + std::ptrdiff_t{part.width_px} * row;
    std::copy(from, from + columns, pixels.begin() + std::ptrdiff_t{width_px} * (y + row) + x);
  }
}

PixelImage plain_image(int width_px, int height_px, std::uint32_t rgb) {
  const auto count = static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
  return {width_px, height_px, std::vector<std::uint32_t>(count, 0xff000000U | rgb)};
}

void write_png(const std::string& path, PixelImage& image) {
  const Canvas canvas(image);
  const cairo_status_t status = cairo_surface_write_to_png(canvas.surface(), path.c_str());
  if (status != CAIRO_STATUS_SUCCESS) {
    throw RunError(path + ": cannot be written (" + cairo_status_to_string(status) +
                   "); is the disk full or the folder read-only?");
  }
}

}  // namespace reamsim
