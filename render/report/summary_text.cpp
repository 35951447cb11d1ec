// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/report/page_data.h"

#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include "render/report/markup.h"
#include "render/report/summary_table.h"
#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/record/run_totals.h"
#include "sim/scenario/choices.h"

namespace reamsim {
namespace {

using Json = nlohmann::ordered_json;

using Line = SummaryLine;

struct Table {
  const char* title;
  std::span<const Line> lines;
};

constexpr std::array kKeyFigures{Line{"/removed_mm3", "Bone removed", "mm³"},
                                 Line{"/metrics/dense_bone_left/mean_mm", "Remaining dense bone, mean", "mm"},
                                 Line{"/balance", "Energy balance", ""}};

constexpr std::array kBone{Line{"/bone/bone_before_mm3", "Bone before", "mm³"},
                           Line{"/bone/bone_after_mm3", "Bone after", "mm³"},
                           Line{"/metrics/removed/total_mm3", "Removed", "mm³"},
                           Line{"/metrics/removed/dense_mm3", "Removed, dense", "mm³"},
                           Line{"/metrics/removed/trabecular_mm3", "Removed, trabecular", "mm³"},
                           Line{"/bone/voxel_mm", "Voxel", "mm"}};
constexpr std::array kSegmentation{
    Line{"/segmentation/method", "Method", ""},
    Line{"/segmentation/threshold_hu", "Threshold", "HU"},
    Line{"/segmentation/bone_mm3", "Segmented bone", "mm³"},
    Line{"/segmentation/below_threshold_fraction", "Fraction below the threshold", ""},
    Line{"/segmentation/density_lower_bound_fraction",
         "Fraction of the surface where density is a lower bound (cortex too thin for the scan)", ""},
    Line{"/segmentation/pieces", "Connected pieces", ""},
    Line{"/segmentation/kept", "Piece kept", ""},
    Line{"/segmentation/kept_rank", "Rank of the kept piece by size", ""},
    Line{"/segmentation/kept_piece_mm3", "Volume of the kept piece before closing", "mm³"},
    Line{"/segmentation/second_piece_mm3", "Second largest piece", "mm³"},
    Line{"/segmentation/dropped_mm3", "Dropped", "mm³"},
    Line{"/segmentation/cut_mm3", "Removed by cuts", "mm³"},
    Line{"/segmentation/closed_mm3", "Added by closing", "mm³"},
    Line{"/segmentation/filled_mm3", "Added by filling", "mm³"}};
constexpr std::array kFace{Line{"/metrics/depth/max_mm", "Depth along the axis, maximum", "mm"},
                           Line{"/metrics/depth/mean_mm", "Depth, mean", "mm"},
                           Line{"/metrics/depth/p95_mm", "Depth, 95th percentile", "mm"},
                           Line{"/metrics/depth/area_mm2", "Reamed area", "mm²"},
                           Line{"/metrics/face/shape", "Shape of the reamed face", ""},
                           Line{"/metrics/face/sphere/radius_mm", "Radius of the fitted sphere", "mm"},
                           Line{"/metrics/face/sphere/residual_rms_mm", "Residual of the sphere, RMS", "mm"},
                           Line{"/metrics/face/plane/residual_rms_mm", "Residual of the plane, RMS", "mm"}};
constexpr std::array kOrientation{
    Line{"/metrics/orientation/native/version_deg", "Version, native face", "°"},
    Line{"/metrics/orientation/reamed/version_deg", "Version, reamed face", "°"},
    Line{"/metrics/orientation/retroversion_corrected_deg", "Retroversion corrected", "°"},
    Line{"/metrics/orientation/native/inclination_deg", "Inclination, native face", "°"},
    Line{"/metrics/orientation/reamed/inclination_deg", "Inclination, reamed face", "°"},
    Line{"/metrics/orientation/inclination_corrected_deg", "Inclination corrected", "°"},
    Line{"/metrics/orientation/native_reason", "Native orientation unknown", ""},
    Line{"/metrics/orientation/reamed_reason", "Reamed orientation unknown", ""},
    Line{"/metrics/orientation/native_shape", "Surface fitted to the native face", ""},
    Line{"/metrics/orientation/reamed_shape", "Surface fitted to the reamed face", ""},
    Line{"/metrics/joint_line/medialization_mm", "Medialization of the joint line", "mm"},
    Line{"/metrics/joint_line/medialization_reason", "Medialization unknown", ""},
    Line{"/metrics/joint_line/reamed_fraction", "Fraction of the face reamed", ""},
    Line{"/metrics/orientation/reamer/version_deg", "Version of the reamer", "°"},
    Line{"/metrics/orientation/reamer/inclination_deg", "Inclination of the reamer", "°"},
    Line{"/metrics/orientation/turned_deg", "Angle between native and reamed axis", "°"},
    Line{"/metrics/orientation/inclination_convention", "Convention of the inclination", "",
         "/metrics/orientation/reamer/inclination_deg"}};
constexpr std::array kRemaining{Line{"/metrics/dense_bone_left/mean_mm", "Dense bone, mean", "mm"},
                                Line{"/metrics/dense_bone_left/p05_mm", "Dense bone, 5th percentile", "mm"},
                                Line{"/metrics/dense_bone_left/least_mm", "Dense bone, least", "mm"},
                                Line{"/metrics/dense_bone_left/exposed_percent", "Face without dense bone", "%"},
                                Line{"/metrics/perforation/perforated", "Perforated", ""},
                                Line{"/metrics/perforation/holes", "Holes", ""},
                                Line{"/metrics/perforation/area_mm2", "Area of the perforations", "mm²"}};
constexpr std::array kLoads{
    Line{"/forces/peak_layer_axial_force_n", "Axial force, peak over a voxel of travel", "N"},
    Line{"/forces/peak_axial_force_n", "Axial force, peak of a single frame", "N"},
    Line{"/forces/mean_axial_force_n", "Axial force, mean", "N"},
    Line{"/forces/peak_layer_spin_torque_nmm", "Spin torque, peak over a voxel of travel", "N·mm"},
    Line{"/forces/peak_spin_torque_nmm", "Spin torque, peak of a single frame", "N·mm"},
    Line{"/forces/mean_spin_torque_nmm", "Spin torque, mean", "N·mm"},
    Line{"/forces/rms_force_n", "Force magnitude, RMS", "N"},
    Line{"/forces/rms_torque_nmm", "Torque magnitude, RMS", "N·mm"}};
constexpr std::array kEnergy{
    Line{"/work_mj", "Work done by the tool", "mJ"}, Line{"/energy_mj", "Cutting energy", "mJ"},
    Line{"/friction_energy_mj", "Friction energy", "mJ"}, Line{"/floor_energy_mj", "Speed-floor energy", "mJ"},
    Line{"/balance", "Energy balance, fraction of the cutting energy", ""}};
constexpr std::array kMotion{Line{"/simulated_s", "Simulated time", "s"},
                             Line{"/reaming_s", "Time in contact", "s"},
                             Line{"/max_depth_mm", "Tool depth, since first contact", "mm"},
                             Line{"/frames", "Frames", ""},
                             Line{"/contact_frames", "Frames in contact", ""},
                             Line{"/first_contact_frame", "First frame in contact", ""}};

constexpr std::array kPush{Line{"/push/mean_feed_mm_s", "Feed rate from first contact on, mean", "mm/s"},
                           Line{"/push/peak_feed_mm_s", "Feed rate in contact, peak", "mm/s"},
                           Line{"/push/hand_work_mj", "Work of the hand", "mJ"},
                           Line{"/push/drill_work_mj", "Work of the drive", "mJ"},
                           Line{"/push/peak_hand_power_w", "Power of the hand, peak", "W"},
                           Line{"/push/peak_drill_power_w", "Power of the drive, peak", "W"},
                           Line{"/push/overshoot_mm", "Travel in 0.2 s after breakthrough", "mm"}};
constexpr std::array kDeflection{
    Line{"/deflection/peak_mm", "Deflection of the springs, peak", "mm"},
    Line{"/deflection/peak_lateral_mm", "Across the axis, peak", "mm"},
    Line{"/deflection/lateral_at_depth_mm", "Across the axis, at the greatest depth", "mm"}};
constexpr std::array kEventColumns{ListColumn{"event", "Event", kTextColumn}, ListColumn{"time_s", "Time, s", 3},
                                   ListColumn{"depth_mm", "Tool depth, mm", 2}, ListColumn{"frame", "Frame", 0}};
constexpr ListTable kEvents{"/push/events", "Events", "No.", kEventColumns};

constexpr std::array kPassColumns{ListColumn{"tool", "Reamer", kTextColumn}, ListColumn{"removed_mm3", "Removed, mm³"},
                                  ListColumn{"max_depth_mm", "Tool depth, mm", 2},
                                  ListColumn{"peak_axial_force_n", "Peak axial force, N"},
                                  ListColumn{"peak_spin_torque_nmm", "Peak spin torque, N·mm", 0}};
constexpr ListTable kPasses{"/passes", "Passes", "Pass", kPassColumns};
constexpr std::array kClearance{Line{"/clearance/least_mm", "Least clearance of the holder", "mm"},
                                Line{"/clearance/part", "Part of the holder", ""},
                                Line{"/clearance/obstacle", "Nearest surface", ""},
                                Line{"/clearance/frame", "Frame", ""},
                                Line{"/clearance/time_s", "Time", "s"},
                                Line{"/clearance/limit_mm", "Limit", "mm"},
                                Line{"/clearance/first_frame_below", "First frame below the limit", ""},
                                Line{"/clearance/last_frame_below", "Last frame below the limit", ""}};

const std::array kTables{Table{"Bone", kBone},
                         Table{"Segmentation", kSegmentation},
                         Table{"Reamed face", kFace},
                         Table{"Orientation", kOrientation},
                         Table{"Remaining bone under the face", kRemaining},
                         Table{"Force and torque", kLoads},
                         Table{"Energy", kEnergy},
                         Table{"Motion", kMotion},
                         Table{"Push", kPush},
                         Table{"Deflection", kDeflection},
                         Table{"Clearance", kClearance}};

InputError wrong(const std::string& path, const std::string& key, const std::string& expected) {
  return {{path, 0, 0}, key, "found another type", "expected " + expected};
}

/// The value at a pointer; null if missing.
Json value_at(const Json& summary, const char* pointer) {
  const Json::json_pointer at(pointer);
  return summary.contains(at) ? summary.at(at) : Json();
}

/// The value of a line as text; "" if missing.
std::string value_text(const Json& summary, const Line& line, const std::string& path) {
  if (*line.only_with != '\0' && value_at(summary, line.only_with).is_null()) return "";
  const Json value = value_at(summary, line.pointer);
  if (value.is_null()) return "";
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_string()) return escape_html(value.get<std::string>());
  if (value.is_number_integer()) return number_text(value.get<double>(), 15);
  if (value.is_number()) return escape_html(measured_text(value.get<double>(), line.unit));
  throw wrong(path, line.pointer, "a number");
}

std::string unit_html(const char* unit) {
  return *unit == '\0' ? "" : std::string(" <span class=\"unit\">") + unit + "</span>";
}

/// Text longer than a number wraps.
std::string row_html(const std::string& head, const std::string& cell, const char* unit = "") {
  constexpr std::size_t kLongestNumber = 24;  // bytes
  const char* const kind = cell.size() > kLongestNumber ? "<td class=\"words\">" : "<td>";
  return "<tr><th scope=\"row\">" + head + "</th>" + kind + cell + unit_html(unit) + "</td></tr>\n";
}

std::string figure_html(std::string name, const std::string& value, const char* unit) {
  name.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(name.front())));
  return "<div><dt>" + name + "</dt><dd>" + value + unit_html(unit) + "</dd></div>\n";
}

/// A number of summary.json; none if missing. Throws InputError for another type.
std::optional<double> number_at(const Json& summary, const char* pointer, const std::string& path) {
  const Json value = value_at(summary, pointer);
  if (value.is_null()) return std::nullopt;
  if (!value.is_number()) throw wrong(path, pointer, "a number");
  return value.get<double>();
}

/// The headline figures, as in pictures and plots.
std::string headline_html(const Json& summary, const std::string& path) {
  KeyResults run{.means = from_name<ErosionMode>(text_at(summary, "erosion", path)) != ErosionMode::exact};
  // Earlier versions wrote these numbers without the section "headline".
  const auto force = run.means ? "/forces/peak_layer_axial_force_n" : "/forces/peak_axial_force_n";
  const auto torque = run.means ? "/forces/peak_layer_spin_torque_nmm" : "/forces/peak_spin_torque_nmm";
  const auto first_of = [&](const char* pointer, const char* earlier) {
    const auto number = number_at(summary, pointer, path);
    return number ? number : number_at(summary, earlier, path);
  };
  std::string out;
  if (const auto depth = first_of("/headline/depth_mm", "/max_depth_mm")) {
    run.tool_depth_mm = *depth;
    out += figure_html(KeyResults::kDepthName, run.depth_text(), "mm");
  }
  if (const auto peak = first_of("/headline/peak_axial_force_n", force)) {
    run.peak_axial_force_n = *peak;
    out += figure_html(run.force_name(), run.force_text(), "N");
  }
  if (const auto peak = first_of("/headline/peak_spin_torque_nmm", torque)) {
    run.peak_spin_torque_nmm = *peak;
    out += figure_html(run.torque_name(), run.torque_text(), "N·mm");
  }
  return out;
}

}  // namespace

std::string text_at(const Json& summary, const char* key, const std::string& path) {
  if (!summary.contains(key) || !summary.at(key).is_string()) throw wrong(path, key, "a text");
  return escape_html(summary.at(key).get<std::string>());
}

std::string key_figures_html(const Json& summary, const std::string& path) {
  std::string out = headline_html(summary, path);
  for (const Line& line : kKeyFigures) {
    const std::string value = value_text(summary, line, path);
    if (value.empty()) continue;
    out += figure_html(line.label, value, line.unit);
  }
  return out;
}

std::string summary_table_html(const Json& summary, const char* title, std::span<const SummaryLine> lines,
                               const std::string& path) {
  std::string rows;
  for (const Line& line : lines) {
    const std::string value = value_text(summary, line, path);
    if (!value.empty()) rows += row_html(line.label, value, line.unit);
  }
  if (rows.empty()) return "";
  return std::string("<table>\n<caption>") + title + "</caption>\n<tbody>\n" + rows + "</tbody>\n</table>\n";
}

std::string summary_tables_html(const Json& summary, const std::string& path) {
  std::string out;
  for (const Table& table : kTables) out += summary_table_html(summary, table.title, table.lines, path);
  return out + list_table_html(summary, kEvents, path) + list_table_html(summary, kPasses, path);
}

std::string provenance_html(const Json& summary, const std::string& path) {
  std::string out = "<table class=\"wide\">\n<caption>Program and settings</caption>\n<tbody>\n";
  constexpr std::array kRows{std::pair{"Program", "program"}, std::pair{"Device", "device"},
                             std::pair{"Engine", "engine"}, std::pair{"Erosion", "erosion"},
                             std::pair{"Force law", "law"}};
  for (const auto& [head, key] : kRows) out += row_html(head, text_at(summary, key, path));
  out += "</tbody>\n</table>\n";
  if (!summary.contains("inputs") || !summary.at("inputs").is_array()) throw wrong(path, "inputs", "a list of files");
  out +=
      "<table class=\"wide\">\n<caption>Inputs</caption>\n<thead><tr><th scope=\"col\">Key</th><th scope=\"col\">"
      "File</th><th scope=\"col\">SHA-256</th></tr></thead>\n<tbody>\n";
  for (const Json& input : summary.at("inputs")) {
    const std::string file = text_at(input, "path", path);
    out += "<tr><th scope=\"row\">" + text_at(input, "role", path) + "</th><td>" + file.substr(file.rfind('/') + 1) +
           "</td><td><code>" + text_at(input, "sha256", path) + "</code></td></tr>\n";
  }
  return out + "</tbody>\n</table>\n";
}

std::string warnings_html(const Json& summary, const std::string& path) {
  if (!summary.contains("warnings") || !summary.at("warnings").is_array()) throw wrong(path, "warnings", "a list");
  if (summary.at("warnings").empty()) return "";
  std::string out = "<aside class=\"warnings\" aria-label=\"Warnings of the run\">\n<h2>Warnings</h2>\n<ul>\n";
  for (const Json& warning : summary.at("warnings")) {
    if (!warning.is_string()) throw wrong(path, "warnings", "a list of texts");
    out += "<li>" + escape_html(warning.get<std::string>()) + "</li>\n";
  }
  return out + "</ul>\n</aside>\n";
}

std::string verification_html(const Json& summary, const Json& verification, const std::string& summary_path,
                              const std::string& verification_path) {
  const Line balance{"/balance", "", ""};
  std::string out =
      "<p>Energy balance of this run: <strong>" + value_text(summary, balance, summary_path) +
      "</strong> of the cutting energy. It is the difference between the work of the tool and the cutting energy of "
      "the removed bone, which are accumulated separately. It checks the bookkeeping, not the bone.</p>\n";
  if (verification.is_null()) {
    return out +
           "<p class=\"status unknown\">This folder contains no verification of the build. Run <code>reamsim "
           "verify</code>, copy its verification.json here, and re-render this folder with <code>reamsim "
           "render</code>.</p>\n";
  }
  if (!verification.contains("passed") || !verification.at("passed").is_boolean() || !verification.contains("cases") ||
      !verification.at("cases").is_array()) {
    throw wrong(verification_path, "passed", "the verification.json of reamsim verify");
  }
  const bool passed = verification.at("passed").get<bool>();
  const auto text = [&](const char* key) { return text_at(verification, key, verification_path); };
  out += std::string("<p class=\"status ") +
         (passed ? "passed\">Verification passed: " : "failed\">Verification FAILED: ") + text("suite") + " suite, " +
         std::to_string(verification.at("cases").size()) + " cases against closed forms and invariants, " +
         text("program") + " on " + text("device") + ".</p>\n";
  for (const char* key : {"program", "device"}) {
    if (text(key) != text_at(summary, key, summary_path)) {
      out += std::string("<p class=\"status unknown\">It was made with another ") + key + " than this run.</p>\n";
    }
  }
  return out;
}

}  // namespace reamsim
