// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "tests/render/picture_file.h"

#include <cairo.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <numeric>

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

namespace {

constexpr int kCell_px = 8;

double linear_from_srgb(double c) {
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

/// CIE L*a*b* (D65, 2 degrees) of linear sRGB.
Eigen::Vector3d lab_from_linear(const Eigen::Vector3d& rgb) {
  Eigen::Matrix3d xyz_from_rgb;
  xyz_from_rgb << 0.4124, 0.3576, 0.1805, 0.2126, 0.7152, 0.0722, 0.0193, 0.1192, 0.9505;
  const Eigen::Vector3d white = xyz_from_rgb * Eigen::Vector3d::Ones();
  const Eigen::Vector3d f = (xyz_from_rgb * rgb).cwiseQuotient(white).unaryExpr([](double t) {
    return t > 216.0 / 24389 ? std::cbrt(t) : t * 841.0 / 108 + 4.0 / 29;
  });
  return {116 * f.y() - 16, 500 * (f.x() - f.y()), 200 * (f.y() - f.z())};
}

Eigen::Vector3d cell_lab(const Picture& picture, int x0, int y0) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int y = y0; y < y0 + kCell_px; ++y) {
    for (int x = x0; x < x0 + kCell_px; ++x) {
      sum += (picture.at(x, y).cast<double>() / 255).unaryExpr(&linear_from_srgb);
    }
  }
  return lab_from_linear(sum / (kCell_px * kCell_px));
}

}  // namespace

double perceived_difference(const Picture& a, const Picture& b) {
  std::vector<double> cells;
  for (int y = 0; y + kCell_px <= a.height; y += kCell_px) {
    for (int x = 0; x + kCell_px <= a.width; x += kCell_px) {
      cells.push_back((cell_lab(a, x, y) - cell_lab(b, x, y)).norm());
    }
  }
  const std::size_t worst = std::max<std::size_t>(1, cells.size() / 100);
  std::ranges::sort(cells, std::greater<>());
  return std::accumulate(cells.begin(), cells.begin() + static_cast<std::ptrdiff_t>(worst), 0.0) /
         static_cast<double>(worst);
}

bool looks_like_bone(const Eigen::Vector3i& rgb) {
  return rgb.x() > rgb.y() && rgb.y() > rgb.z() && rgb.x() - rgb.z() > 15 && rgb.x() > 60;
}

}  // namespace reamsim::test
