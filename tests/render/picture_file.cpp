#include "tests/render/picture_file.h"

#include <cairo.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

namespace reamsim::test {

Eigen::Vector3i Picture::at(int x, int y) const {
  const std::uint32_t p =
      pixels.at(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  return {static_cast<int>(p >> 16 & 255), static_cast<int>(p >> 8 & 255), static_cast<int>(p & 255)};
}

Picture read_picture(const std::string& path) {
  cairo_surface_t* surface = cairo_image_surface_create_from_png(path.c_str());
  Picture out;
  if (cairo_surface_status(surface) == CAIRO_STATUS_SUCCESS) {
    out.width = cairo_image_surface_get_width(surface);
    out.height = cairo_image_surface_get_height(surface);
    const unsigned char* data = cairo_image_surface_get_data(surface);
    const int stride = cairo_image_surface_get_stride(surface);
    out.pixels.resize(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height));
    for (int y = 0; y < out.height; ++y) {
      std::memcpy(out.pixels.data() + std::ptrdiff_t{y} * out.width, data + std::ptrdiff_t{y} * stride,
                  static_cast<std::size_t>(out.width) * 4);
    }
  }
  cairo_surface_destroy(surface);
  return out;
}

int largest_difference(const Picture& a, const Picture& b) {
  int largest = 0;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) largest = std::max(largest, (a.at(x, y) - b.at(x, y)).cwiseAbs().maxCoeff());
  }
  return largest;
}

bool looks_like_bone(const Eigen::Vector3i& rgb) {
  return rgb.x() > rgb.y() && rgb.y() > rgb.z() && rgb.x() - rgb.z() > 15 && rgb.x() > 60;
}

}  // namespace reamsim::test
