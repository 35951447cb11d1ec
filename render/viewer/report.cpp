// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <cairo.h>
#include <fmt/core.h>
// jpeglib.h needs size_t and FILE before it.
#include <cstdio>

#include <jpeglib.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <set>
#include <span>
#include <vector>

#include "render/pictures/canvas.h"
#include "render/viewer/page.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/parallel.h"
#include "sim/record/result_json.h"

namespace reamsim {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

/// About the horizontal resolution of a screen.
constexpr std::size_t kMaxBuckets = 1000;

Json read_json(const std::string& path, const std::string& expected) {
  Json json = parse_result_json(read_file(path, expected));
  if (!json.is_object()) refuse_file(path, "is not a JSON object", expected);
  return json;
}

std::string plain_text(const Json& value) {
  if (value.is_null()) return "–";
  if (value.is_string()) return escape_html(value.get<std::string>());
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  return value.is_number_float() ? fmt::format("{:.6g}", value.get<double>()) : value.dump();
}

std::string plain_row(const Json& cells) {
  std::string out;
  for (const Json& cell : cells) out += "<td>" + plain_text(cell) + "</td>";
  return "<tr>" + out + "</tr>\n";
}

std::string plain_table(const std::string& title, const Json& table) {
  std::string out = "<table>\n<caption>" + title + "</caption>\n";
  if (table.contains("columns")) out += plain_row(table["columns"]);
  for (const Json& row : table["rows"]) out += plain_row(row);
  return out + "</table>\n";
}

/// What the page makes of summary_data(), plain, for readers without JavaScript.
std::string plain_html(const Json& summary) {
  std::string out = plain_table("Key figures", {{"rows", summary["key_figures"]}});
  for (const Json& warning : summary["warnings"]) out += "<p>Warning: " + plain_text(warning) + "</p>\n";
  for (const char* part : {"planning", "measurements", "provenance"}) {
    for (const Json& table : summary[part]) out += plain_table(table["title"].get<std::string>(), table);
  }
  if (summary["verification"].is_null()) return out;
  return out +
         "<p>Verification of the build: " + (summary["verification"]["passed"].get<bool>() ? "passed" : "FAILED") +
         "</p>\n";
}

// --- pictures

// Limits in base64 bytes that keep the page below 15 MB, with 4 MB for the 3D view and the curves.
constexpr std::size_t kMaxPictureBytes = 3'000'000;
constexpr std::size_t kMaxFrameBytes = 5'500'000;
constexpr int kPicture_px = 1600;
constexpr int kFrame_px = 1200;
constexpr std::size_t kMaxFrames = 120;  // of all cameras
constexpr int kQuality = 86;             // least quality without artefacts around text

using Png = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;

Png read_png(const std::string& path) {
  Png image(cairo_image_surface_create_from_png(path.c_str()), &cairo_surface_destroy);
  if (cairo_surface_status(image.get()) != CAIRO_STATUS_SUCCESS) {
    // Cairo reports every error of libpng as missing memory.
    refuse_file(path, "is not a readable picture, or memory is exhausted", "a PNG written by reamsim render");
  }
  return image;
}

std::string jpeg_base64(PixelImage& image) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &bytes, &size);
  jpeg.image_width = static_cast<JDIMENSION>(image.width_px);
  jpeg.image_height = static_cast<JDIMENSION>(image.height_px);
  jpeg.input_components = 4;
  jpeg.in_color_space = JCS_EXT_BGRX;  // a Cairo pixel on a little-endian machine
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, kQuality, TRUE);
  jpeg.optimize_coding = TRUE;
  jpeg_start_compress(&jpeg, TRUE);
  while (jpeg.next_scanline < jpeg.image_height) {
    auto* row = reinterpret_cast<JSAMPROW>(&image.pixels[image.index(0, static_cast<int>(jpeg.next_scanline))]);
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

/// Scaled down to at most `most_px` wide, on white.
PagePicture page_picture(cairo_surface_t* image, int most_px) {
  const int width = cairo_image_surface_get_width(image), height = cairo_image_surface_get_height(image);
  const double scale = std::min(1.0, static_cast<double>(most_px) / width);
  const auto reduced = [&](int pixels) { return std::max(1, static_cast<int>(std::lround(pixels * scale))); };
  PixelImage small = scaled_middle(image, reduced(width), reduced(height));
  return {.width_px = small.width_px, .height_px = small.height_px, .jpeg_base64 = jpeg_base64(small)};
}

/// Those of `ready`, or PNG files converted to JPEGs in base 64, at most `most_px` wide. If they exceed `most_bytes`
/// together, all are reduced until they fit or are an eighth as wide. Throws InputError when one cannot be read.
std::vector<PagePicture> page_pictures(const std::vector<std::string>& paths, int most_px, std::size_t most_bytes,
                                       const PagePictures& ready) {
  std::vector<PagePicture> out(paths.size());
  for (int width = most_px; width >= most_px / 8; width = width * 3 / 4) {
    parallel_items(paths.size(), [&](std::size_t i) {
      const auto found = width == most_px ? ready.find(paths[i]) : ready.end();
      out[i] = found != ready.end() ? found->second : page_picture(read_png(paths[i]).get(), width);
    });
    std::size_t bytes = 0;
    for (const PagePicture& picture : out) bytes += picture.jpeg_base64.size();
    if (bytes <= most_bytes) break;
  }
  return out;
}

/// Adds the final pictures of a folder as figures: the first as `bone_figure`, which stands in place of the 3D view on
/// paper and without JavaScript, the others as `figures`. `first_camera` is the one without a suffix.
void add_figures(const std::string& dir, const std::string& first_camera, const PagePictures& ready, PageTexts& texts) {
  std::string &first = texts["bone_figure"], &others = texts["figures"];
  const std::vector<std::string> paths = final_pictures(dir);
  const std::vector<PagePicture> pictures = page_pictures(paths, kPicture_px, kMaxPictureBytes, ready);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const PagePicture& picture = pictures[i];
    const std::string caption = escape_html(caption_of(fs::path(paths[i]).stem().string(), first_camera));
    (first.empty() ? first : others) += fmt::format(
        "<figure{0}><img alt=\"{1}\" width=\"{2}\" height=\"{3}\" src=\"data:image/jpeg;base64,{4}\"><figcaption>{1}"
        "</figcaption></figure>\n",
        first.empty() ? " id=\"bone-still\"" : "", caption, picture.width_px, picture.height_px, picture.jpeg_base64);
  }
}

/// The pictures during the run, and the cameras that have one of each of these frames.
Json frames_json(const RunData& run, const std::vector<std::string>& cameras, const PagePictures& ready) {
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
    const auto pictures = page_pictures(paths, kFrame_px, kMaxFrameBytes / cameras.size(), ready);
    Json view{{"name", camera}, {"width_px", pictures.front().width_px}, {"height_px", pictures.front().height_px}};
    for (const PagePicture& picture : pictures) view["jpegs"].push_back(picture.jpeg_base64);
    json["cameras"].push_back(std::move(view));
  }
  return json;
}

/// The gnuplot figure, for print (HTML); "" if missing.
std::string printed_plot_html(const std::string& dir) {
  const std::string path = dir + "/forces.png";
  if (!fs::exists(path)) return "";
  const std::string png = read_file(path, "a picture");
  return "<img class=\"print-only\" alt=\"Force, torque, removed volume and depth against time\" "
         "src=\"data:image/png;base64," +
         base64({reinterpret_cast<const std::uint8_t*>(png.data()), png.size()}) + "\">";
}

}  // namespace

std::vector<std::size_t> evenly_spaced(std::size_t count, std::size_t most) {
  std::vector<std::size_t> out;
  const std::size_t chosen = std::min(count, most);
  for (std::size_t i = 0; i < chosen; ++i) {
    out.push_back(chosen == 1 ? count - 1 : i * (count - 1) / (chosen - 1));
  }
  return out;
}

std::vector<std::size_t> shown_rows(const std::vector<ForceRow>& rows) {
  const std::size_t bucket = 1 + (rows.size() - 1) / kMaxBuckets;
  std::vector<std::size_t> out;
  for (std::size_t from = 0; from < rows.size(); from += bucket) {
    const auto group = std::span(rows).subspan(from, std::min(bucket, rows.size() - from));
    std::set<std::size_t> chosen{from};
    const auto choose_extremes = [&](const auto& value) {
      const auto [least, most] = std::ranges::minmax_element(group, {}, value);
      chosen.insert({from + static_cast<std::size_t>(least - group.begin()),
                     from + static_cast<std::size_t>(most - group.begin())});
    };
    choose_extremes(&ForceRow::axial_force_n);
    choose_extremes(&ForceRow::spin_torque_nmm);
    choose_extremes([](const ForceRow& row) { return row.push.value_or(PushResult{}).feed_mm_s; });
    out.insert(out.end(), chosen.begin(), chosen.end());
  }
  if (out.back() != rows.size() - 1) out.push_back(rows.size() - 1);
  return out;
}

nlohmann::ordered_json plot_data(const ForceLog& log, double mean_travel_mm) {
  Json json{{"mean_travel_mm", mean_travel_mm}};
  const std::vector<std::size_t> shown = shown_rows(log.rows);
  const auto column = [&](const char* name, const auto& value) {
    Json& values = json[name] = Json::array();
    for (const std::size_t i : shown) values.push_back(short_number(std::invoke(value, log.rows[i])));
  };
  for (const std::size_t i : shown) json["frame"].push_back(log.rows[i].frame);
  column("time_s", &ForceRow::time_s);
  column("depth_mm", &ForceRow::depth_mm);
  column("axial_force_n", &ForceRow::axial_force_n);
  column("spin_torque_nmm", &ForceRow::spin_torque_nmm);
  column("removed_mm3", &ForceRow::removed_mm3);
  if (mean_travel_mm > 0) {
    column("mean_axial_force_n", &ForceRow::layer_axial_force_n);
    column("mean_spin_torque_nmm", &ForceRow::layer_spin_torque_nmm);
  }
  if (log.rows.back().push) {
    column("feed_mm_s", [](const ForceRow& row) { return row.push.value_or(PushResult{}).feed_mm_s; });
    column("drill_power_w", [](const ForceRow& row) { return row.push.value_or(PushResult{}).drill_power_w; });
  }
  return json;
}

void keep_page_picture(const std::string& dir, const std::string& path, PixelImage& image, PagePictures& pictures) {
  const bool along_run = path.starts_with(dir + "/frames/");
  if (along_run ? pictures.size() >= kMaxFrames : !path.starts_with(dir + "/reamed")) return;
  pictures[path] = page_picture(Canvas(image).surface(), along_run ? kFrame_px : kPicture_px);
}

ReportParts report_parts(const RunData& run, const RenderSettings& settings, const std::function<Json()>& bone,
                         const PagePictures& ready) {
  ReportParts out;
  out.pictures = frames_json(run, names_of(settings.cameras), ready);
  out.bone = bone();
  add_figures(run.dir(), name_of(settings.cameras.front()), ready, out.figures);
  return out;
}

void write_report(const RunData& run, const RenderSettings& settings, const ReportParts& parts) {
  const std::string& dir = run.dir();
  const std::string summary_path = dir + "/summary.json", verification_path = dir + "/verification.json";
  const Json summary = read_json(summary_path, "the summary.json of a run");
  const Json verification =
      fs::exists(verification_path) ? read_json(verification_path, "the verification.json of reamsim verify") : Json();
  const auto text = [&](const char* key) { return text_at(summary, key, summary_path); };
  const std::string title = text("scenario"), program = text("program");
  const Json tables = summary_data(summary, verification, summary_path, verification_path);
  PageTexts texts{{"device", escape_html(text("device"))},
                  {"plain", plain_html(tables)},
                  {"printed_plot", printed_plot_html(dir)},
                  {"scenario", escape_html(read_file(dir + "/scenario.yaml", "the scenario.yaml of a run"))}};
  texts.insert(parts.figures.begin(), parts.figures.end());
  const ForceLog& log = run.log();
  const Json data{{"plot", plot_data(log, log.mean_travel_mm)},
                  {"pictures", parts.pictures},
                  {"bone", parts.bone},
                  {"tool", tool_data(run.inputs().passes, log, settings)},
                  {"summary", tables}};
  write_file(dir + "/report.html", self_contained_page(embedded::report_page, title, program, data, std::move(texts)));
}

}  // namespace reamsim
