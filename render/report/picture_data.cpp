// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/report/page_data.h"

#include <cairo.h>
// jpeglib.h needs size_t and FILE before it.
#include <cstdio>

#include <jpeglib.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <new>

#include "render/report/markup.h"
#include "sim/base/error.h"
#include "sim/base/parallel.h"

namespace reamsim {
namespace {

constexpr int kQuality = 86;  // least quality without artefacts around text

using Image = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;

/// Throws bad_alloc where Cairo had no memory: it only sets the status of the surface.
void check_memory(const Image& image) {
  if (cairo_surface_status(image.get()) == CAIRO_STATUS_NO_MEMORY) throw std::bad_alloc();
}

Image read_png(const std::string& path) {
  Image image(cairo_image_surface_create_from_png(path.c_str()), &cairo_surface_destroy);
  if (cairo_surface_status(image.get()) != CAIRO_STATUS_SUCCESS) {
    // Cairo reports every error of libpng as missing memory.
    throw InputError({path, 0, 0}, "", "is not a readable picture, or memory is exhausted",
                     "a PNG written by reamsim render");
  }
  return image;
}

/// Scaled down to at most `most_px` wide, on white.
Image scaled(const Image& image, int most_px) {
  const int width = cairo_image_surface_get_width(image.get());
  const int height = cairo_image_surface_get_height(image.get());
  const double scale = std::min(1.0, static_cast<double>(most_px) / width);
  const int new_width = std::max(1, static_cast<int>(std::lround(width * scale)));
  const int new_height = std::max(1, static_cast<int>(std::lround(height * scale)));
  Image out(cairo_image_surface_create(CAIRO_FORMAT_RGB24, new_width, new_height), &cairo_surface_destroy);
  cairo_t* pen = cairo_create(out.get());
  cairo_set_source_rgb(pen, 1, 1, 1);
  cairo_paint(pen);
  cairo_scale(pen, static_cast<double>(new_width) / width, static_cast<double>(new_height) / height);
  cairo_set_source_surface(pen, image.get(), 0, 0);
  cairo_pattern_set_filter(cairo_get_source(pen), CAIRO_FILTER_GOOD);
  cairo_paint(pen);
  cairo_destroy(pen);
  cairo_surface_flush(out.get());
  check_memory(out);
  return out;
}

std::string jpeg_base64(const Image& image) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &bytes, &size);
  jpeg.image_width = static_cast<JDIMENSION>(cairo_image_surface_get_width(image.get()));
  jpeg.image_height = static_cast<JDIMENSION>(cairo_image_surface_get_height(image.get()));
  jpeg.input_components = 4;
  jpeg.in_color_space = JCS_EXT_BGRX;  // a Cairo pixel on a little-endian machine
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, kQuality, TRUE);
  jpeg.optimize_coding = TRUE;
  jpeg_start_compress(&jpeg, TRUE);
  unsigned char* pixels = cairo_image_surface_get_data(image.get());
  const int stride = cairo_image_surface_get_stride(image.get());
  while (jpeg.next_scanline < jpeg.image_height) {
    JSAMPROW row = pixels + static_cast<std::ptrdiff_t>(stride) * jpeg.next_scanline;
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  std::string out = base64({bytes, size});
  jpeg_destroy_compress(&jpeg);
  std::free(bytes);
  return out;
}

}  // namespace

std::vector<PagePicture> page_pictures(const std::vector<std::string>& paths, int most_px, std::size_t most_bytes) {
  std::vector<PagePicture> out(paths.size());
  for (int width = most_px; width >= most_px / 8; width = width * 3 / 4) {
    parallel_items(paths.size(), [&](std::size_t i) {
      const Image image = scaled(read_png(paths[i]), width);
      out[i] = {.name = std::filesystem::path(paths[i]).stem().string(),
                .width_px = cairo_image_surface_get_width(image.get()),
                .height_px = cairo_image_surface_get_height(image.get()),
                .jpeg_base64 = jpeg_base64(image)};
    });
    std::size_t bytes = 0;
    for (const PagePicture& picture : out) bytes += picture.jpeg_base64.size();
    if (bytes <= most_bytes) break;
  }
  return out;
}

std::vector<std::size_t> evenly_spaced(std::size_t count, std::size_t most) {
  std::vector<std::size_t> out;
  const std::size_t chosen = std::min(count, most);
  for (std::size_t i = 0; i < chosen; ++i) {
    out.push_back(chosen == 1 ? count - 1 : i * (count - 1) / (chosen - 1));
  }
  return out;
}

}  // namespace reamsim
