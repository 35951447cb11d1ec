// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The pictures of the page.
#include <cairo.h>
#include <fmt/core.h>
// jpeglib.h needs size_t and FILE before it.
#include <cstdio>

#include <jpeglib.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <new>

#include "render/viewer/page.h"
#include "render/viewer/report_data.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/parallel.h"

namespace reamsim {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

// Limits in base64 bytes that keep the page below 15 MB, with 4 MB for the 3D view and the curves.
constexpr std::size_t kMaxPictureBytes = 3'000'000;
constexpr std::size_t kMaxFrameBytes = 5'500'000;
constexpr int kPicture_px = 1600;
constexpr int kFrame_px = 1200;
constexpr std::size_t kMaxFrames = 120;  // of all cameras
constexpr int kQuality = 86;             // least quality without artefacts around text

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

/// The caption of a final picture by its file name; `first`: the camera without suffix.
std::string caption_of(const std::string& name, const std::string& first) {
  if (name == "depth_map") return "Depth of the removed bone, seen along the axis of the glenoid";
  if (name == "segmentation") return "The CT with the outline of the segmented bone, in three planes";
  const std::string camera = name == "reamed" ? first : name.substr(std::string("reamed_").size());
  if (camera == "overview") return "The whole bone";
  if (camera == "oblique") return "The reamed bone, oblique";
  if (camera == "glenoid") return "The reamed bone, en face";
  return "The reamed bone" + (camera == "section" ? ", section along the tool axis" : ": " + camera);
}

/// The final pictures of a folder: reamed.png, the other reamed_*.png by name, depth_map.png, segmentation.png.
std::vector<std::string> final_pictures(const std::string& dir) {
  std::vector<std::string> out;
  for (const auto& entry : fs::directory_iterator(dir)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("reamed_") && name.ends_with(".png")) out.push_back(entry.path().string());
  }
  std::sort(out.begin(), out.end());
  if (fs::exists(dir + "/reamed.png")) out.insert(out.begin(), dir + "/reamed.png");
  for (const char* name : {"/depth_map.png", "/segmentation.png"}) {
    if (fs::exists(dir + name)) out.push_back(dir + name);
  }
  return out;
}

std::string frame_path(const std::string& dir, std::int64_t frame, const std::string& suffix) {
  return fmt::format("{}/frames/{:06}{}.png", dir, frame, suffix);
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

std::vector<std::string> figures_html(const std::string& dir, const std::string& first_camera) {
  std::vector<std::string> out;
  for (const PagePicture& picture : page_pictures(final_pictures(dir), kPicture_px, kMaxPictureBytes)) {
    const std::string caption = escape_html(caption_of(picture.name, first_camera));
    out.push_back(fmt::format(
        "<figure{0}><img alt=\"{1}\" width=\"{2}\" height=\"{3}\" src=\"data:image/jpeg;base64,{4}\"><figcaption>{1}"
        "</figcaption></figure>\n",
        out.empty() ? " id=\"bone-still\"" : "", caption, picture.width_px, picture.height_px, picture.jpeg_base64));
  }
  return out;
}

Json frames_json(const RunData& run, const std::vector<std::string>& cameras) {
  Json json{{"frames", Json::array()}, {"time_s", Json::array()}, {"cameras", Json::array()}};
  const std::string& dir = run.dir();
  std::vector<std::int64_t> drawn = run.inputs().frames;
  std::erase_if(drawn, [&](std::int64_t frame) { return !fs::exists(frame_path(dir, frame, "")); });
  std::vector<std::int64_t> frames;
  for (const std::size_t i : evenly_spaced(drawn.size(), std::max<std::size_t>(2, kMaxFrames / cameras.size()))) {
    frames.push_back(drawn[i]);
    json["frames"].push_back(frames.back());
    json["time_s"].push_back(short_number(run.row_of(frames.back()).time_s));
  }
  if (frames.empty()) return json;
  for (const std::string& camera : cameras) {
    std::vector<std::string> paths;
    for (const std::int64_t frame : frames) {
      paths.push_back(frame_path(dir, frame, camera == cameras.front() ? "" : "_" + camera));
    }
    if (!std::ranges::all_of(paths, [](const std::string& path) { return fs::exists(path); })) continue;
    const auto pictures = page_pictures(paths, kFrame_px, kMaxFrameBytes / cameras.size());
    Json view{{"name", camera}, {"width_px", pictures.front().width_px}, {"height_px", pictures.front().height_px}};
    for (const PagePicture& picture : pictures) view["jpegs"].push_back(picture.jpeg_base64);
    json["cameras"].push_back(std::move(view));
  }
  return json;
}

std::string printed_plot_html(const std::string& dir) {
  const std::string path = dir + "/forces.png";
  if (!fs::exists(path)) return "";
  const std::string png = read_file(path, "a picture");
  return "<img class=\"print-only\" alt=\"Force, torque, removed volume and depth against time\" "
         "src=\"data:image/png;base64," +
         base64({reinterpret_cast<const std::uint8_t*>(png.data()), png.size()}) + "\">";
}

}  // namespace reamsim
