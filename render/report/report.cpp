// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/report/report.h"

#include <fmt/core.h>
#include <algorithm>
#include <filesystem>
#include <map>
#include <vector>

#include "render/plots/plots.h"
#include "render/report/markup.h"
#include "render/report/page_data.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/record/result_json.h"

namespace reamsim {
namespace embedded {
extern const char* const report_page;
extern const char* const report_script;
extern const char* const report_style;
}  // namespace embedded
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

// Limits in base64 bytes that keep the page below 15 MB, with 4 MB for the 3D view and the curves.
constexpr std::size_t kMaxPictureBytes = 3'000'000;
constexpr std::size_t kMaxFrameBytes = 5'500'000;
constexpr int kPicture_px = 1600;
constexpr int kFrame_px = 1200;
constexpr std::size_t kMaxFrames = 120;  // of all cameras

Json read_json(const std::string& path, const std::string& expected) {
  Json json = parse_result_json(read_file(path, expected));
  if (!json.is_object()) throw InputError({path, 0, 0}, "", "is not a JSON object", expected);
  return json;
}

/// The caption of a final picture by its file name; `first`: the camera without suffix.
std::string caption_of(const std::string& name, const std::string& first) {
  if (name == "depth_map") return "Depth of the removed bone, seen along the axis of the glenoid";
  if (name == "segmentation") return "The CT with the outline of the segmented bone, in three planes";
  const std::string camera = name == "reamed" ? first : name.substr(std::string("reamed_").size());
  const auto view = from_name<CameraView>(camera);
  if (view == CameraView::oblique) return "The reamed bone, oblique";
  if (view == CameraView::glenoid) return "The reamed bone, en face";
  if (view == CameraView::section) return "The reamed bone, section along the tool axis";
  if (view == CameraView::overview) return "The whole bone";
  return "The reamed bone: " + camera;
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

/// The final pictures as figures.
std::vector<std::string> figures_html(const std::string& dir, const std::string& first_camera) {
  std::vector<std::string> out;
  for (const PagePicture& picture : page_pictures(final_pictures(dir), kPicture_px, kMaxPictureBytes)) {
    const std::string caption = escape_html(caption_of(picture.name, first_camera));
    out.push_back(std::string(out.empty() ? "<figure id=\"bone-still\">" : "<figure>") + "<img alt=\"" + caption +
                  "\" width=\"" + std::to_string(picture.width_px) + "\" height=\"" +
                  std::to_string(picture.height_px) + "\" src=\"data:image/jpeg;base64," + picture.jpeg_base64 +
                  "\"><figcaption>" + caption + "</figcaption></figure>\n");
  }
  return out;
}

std::string frame_path(const std::string& dir, std::int64_t frame, const std::string& suffix) {
  return fmt::format("{}/frames/{:06}{}.png", dir, frame, suffix);
}

/// The pictures during the run: `frames` and `time_s`, and for each camera with a picture of all these frames its
/// `name`, `width_px`, `height_px` and `jpegs`.
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
    if (!std::all_of(paths.begin(), paths.end(), [](const std::string& path) { return fs::exists(path); })) continue;
    const auto pictures = page_pictures(paths, kFrame_px, kMaxFrameBytes / cameras.size());
    Json view{{"name", camera}, {"width_px", pictures.front().width_px}, {"height_px", pictures.front().height_px}};
    for (const PagePicture& picture : pictures) view["jpegs"].push_back(picture.jpeg_base64);
    json["cameras"].push_back(std::move(view));
  }
  return json;
}

/// The gnuplot figure, for print; "" if missing.
std::string printed_plot_html(const std::string& dir) {
  const std::string path = dir + "/forces.png";
  if (!fs::exists(path)) return "";
  const std::string png = read_file(path, "a picture");
  return "<img class=\"print-only\" alt=\"Force, torque, removed volume and depth against time\" "
         "src=\"data:image/png;base64," +
         base64({reinterpret_cast<const std::uint8_t*>(png.data()), png.size()}) + "\">";
}

/// The data of the page's scripts.
Json script_data(const RunData& run, const PictureOptions& options) {
  ForceLog log = run.log();
  add_layer_means(log, options.mean_travel_mm);
  return {{"plot", plot_data(log, options.mean_travel_mm)},
          {"pictures", frames_json(run, names_of(options.settings.cameras))},
          {"bone", bone_data(run, options.settings)},
          {"tool", tool_data(run.inputs().passes, log, options.settings)}};
}

std::string page_html(const RunData& run, const PictureOptions& options) {
  const std::string& dir = run.dir();
  const std::string summary_path = dir + "/summary.json", verification_path = dir + "/verification.json";
  const Json summary = read_json(summary_path, "the summary.json of a run");
  const Json verification =
      fs::exists(verification_path) ? read_json(verification_path, "the verification.json of reamsim verify") : Json();
  std::map<std::string, std::string> texts{
      {"title", text_at(summary, "scenario", summary_path)},
      {"program", text_at(summary, "program", summary_path)},
      {"device", text_at(summary, "device", summary_path)},
      {"style", embedded::report_style},
      {"warnings", warnings_html(summary, summary_path)},
      {"key_figures", key_figures_html(summary, summary_path)},
      {"planning", planning_html(summary, summary_path)},
      {"tables", summary_tables_html(summary, summary_path)},
      {"printed_plot", printed_plot_html(dir)},
      {"verification", verification_html(summary, verification, summary_path, verification_path)},
      {"provenance", provenance_html(summary, summary_path)},
      {"scenario", escape_html(read_file(dir + "/scenario.yaml", "the scenario.yaml of a run"))},
      {"bone_figure", ""},  // the first picture: in place of the 3D view on paper and without JavaScript
      {"figures", ""},
      {"script", embedded::report_script}};
  // The slow parts come last, after the checks of the others.
  const auto figures = figures_html(dir, name_of(options.settings.cameras.front()));
  for (std::size_t i = 0; i < figures.size(); ++i) texts[i == 0 ? "bone_figure" : "figures"] += figures[i];
  texts["data"] = json_for_script(script_data(run, options));
  return fill_template(embedded::report_page, texts);
}

}  // namespace

void write_report(const RunData& run, const PictureOptions& options) {
  if (options.settings.cameras.empty()) {
    throw InputError({}, "render.cameras", "found none", "expected at least one camera");
  }
  write_file(run.dir() + "/report.html", page_html(run, options));
}

}  // namespace reamsim
