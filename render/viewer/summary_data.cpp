// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <array>
#include <initializer_list>
#include <optional>
#include <span>

#include "render/viewer/page.h"
#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/record/run_totals.h"
#include "sim/scenario/choices.h"

namespace reamsim {
namespace {

using Json = nlohmann::ordered_json;

/// A row of a table, with the JSON pointer of its value in summary.json.
struct Line {
  const char* pointer = nullptr;
  const char* label = nullptr;
  const char* unit = nullptr;
  const char* only_with = "";  ///< pointer of a value without which the row is left out
};

struct Table {
  const char* title;
  std::initializer_list<Line> lines;
};

/// A column of a table with a row for each item of a list.
struct ListColumn {
  const char* key = nullptr;  ///< in the item
  const char* title = nullptr;
  int decimals = 1;  ///< kText: a text, of a path its last part
};
constexpr int kText = -1;

struct ListTable {
  const char* pointer;  ///< of the list in summary.json
  const char* title;
  const char* item;  ///< heads the column of the numbers, from 1
  std::initializer_list<ListColumn> columns;
};

constexpr Line kKeyFigures[]{{"/removed_mm3", "Bone removed", "mm³"},
                             {"/metrics/dense_bone_left/mean_mm", "Remaining dense bone, mean", "mm"},
                             {"/balance", "Energy balance", ""}};

constexpr const char* kScapula = "/metrics/orientation/reamer/inclination_deg";  // of a known scapular frame
constexpr const char* kVersions = "/metrics/version/by_landmarks";               // more than one definition

constexpr Table kMeasurements[]{
    {"Bone",
     {{"/bone/bone_before_mm3", "Bone before", "mm³"},
      {"/bone/bone_after_mm3", "Bone after", "mm³"},
      {"/metrics/removed/total_mm3", "Removed", "mm³"},
      {"/metrics/removed/dense_mm3", "Removed, dense", "mm³"},
      {"/metrics/removed/trabecular_mm3", "Removed, trabecular", "mm³"},
      {"/bone/voxel_mm", "Voxel", "mm"}}},
    {"Segmentation",
     {{"/segmentation/method", "Method", ""},
      {"/segmentation/threshold_hu", "Threshold", "HU"},
      {"/segmentation/bone_mm3", "Segmented bone", "mm³"},
      {"/segmentation/below_threshold_fraction", "Fraction below the threshold", ""},
      {"/segmentation/density_lower_bound_fraction",
       "Fraction of the surface where density is a lower bound (cortex too thin for the scan)", ""},
      {"/segmentation/pieces", "Connected pieces", ""},
      {"/segmentation/kept", "Piece kept", ""},
      {"/segmentation/kept_rank", "Rank of the kept piece by size", ""},
      {"/segmentation/kept_piece_mm3", "Volume of the kept piece before closing", "mm³"},
      {"/segmentation/second_piece_mm3", "Second largest piece", "mm³"},
      {"/segmentation/dropped_mm3", "Dropped", "mm³"},
      {"/segmentation/cut_mm3", "Removed by cuts", "mm³"},
      {"/segmentation/closed_mm3", "Added by closing", "mm³"},
      {"/segmentation/filled_mm3", "Added by filling", "mm³"}}},
    {"Reamed face",
     {{"/metrics/depth/max_mm", "Depth along the axis, maximum", "mm"},
      {"/metrics/depth/mean_mm", "Depth, mean", "mm"},
      {"/metrics/depth/p95_mm", "Depth, 95th percentile", "mm"},
      {"/metrics/depth/area_mm2", "Reamed area", "mm²"},
      {"/metrics/face/shape", "Shape of the reamed face", ""},
      {"/metrics/face/sphere/radius_mm", "Radius of the fitted sphere", "mm"},
      {"/metrics/face/sphere/residual_rms_mm", "Residual of the sphere, RMS", "mm"},
      {"/metrics/face/plane/residual_rms_mm", "Residual of the plane, RMS", "mm"}}},
    {"Orientation",
     {{"/metrics/orientation/native/version_deg", "Version, native face", "°"},
      {"/metrics/orientation/reamed/version_deg", "Version, reamed face", "°"},
      {"/metrics/orientation/retroversion_corrected_deg", "Retroversion corrected", "°"},
      {"/metrics/orientation/native/inclination_deg", "Inclination, native face", "°"},
      {"/metrics/orientation/reamed/inclination_deg", "Inclination, reamed face", "°"},
      {"/metrics/orientation/inclination_corrected_deg", "Inclination corrected", "°"},
      {"/metrics/orientation/native_reason", "Native orientation unknown", ""},
      {"/metrics/orientation/reamed_reason", "Reamed orientation unknown", ""},
      {"/metrics/orientation/native_shape", "Surface fitted to the native face", ""},
      {"/metrics/orientation/reamed_shape", "Surface fitted to the reamed face", ""},
      {"/metrics/joint_line/medialization_mm", "Medialization of the joint line", "mm"},
      {"/metrics/joint_line/medialization_reason", "Medialization unknown", ""},
      {"/metrics/joint_line/reamed_fraction", "Fraction of the face reamed", ""},
      {"/metrics/orientation/reamer/version_deg", "Version of the reamer", "°"},
      {"/metrics/orientation/reamer/inclination_deg", "Inclination of the reamer", "°"},
      {"/metrics/orientation/turned_deg", "Angle between native and reamed axis", "°"},
      {"/metrics/orientation/inclination_convention", "Convention of the inclination", "", kScapula}}},
    {"Version before reaming, by definition",
     {{"/metrics/version/face_axis_deg", "Axis of the face", "°", kVersions},
      {"/metrics/version/two_planes_deg", "Two planes: rim against scapular plane (Ganapathi et al. 2011)", "°",
       kVersions},
      {"/metrics/version/friedman_2d_deg", "Axial slice: margins against medial tip (Friedman et al. 1992)", "°",
       kVersions},
      {"/metrics/version/vault_2d_deg", "Axial slice: margins against tip of the vault (Matsumura et al. 2014)", "°",
       kVersions},
      {"/metrics/version/face_axis_reason", "Axis of the face unknown", "", kVersions},
      {"/metrics/version/two_planes_reason", "Two planes unknown", "", kVersions},
      {"/metrics/version/friedman_2d_reason", "Margins against medial tip unknown", "", kVersions},
      {"/metrics/version/vault_2d_reason", "Margins against tip of the vault unknown", "", kVersions}}},
    {"Remaining bone under the face",
     {{"/metrics/dense_bone_left/mean_mm", "Dense bone, mean", "mm"},
      {"/metrics/dense_bone_left/p05_mm", "Dense bone, 5th percentile", "mm"},
      {"/metrics/dense_bone_left/least_mm", "Dense bone, least", "mm"},
      {"/metrics/dense_bone_left/exposed_percent", "Face without dense bone", "%"},
      {"/metrics/perforation/perforated", "Perforated", ""},
      {"/metrics/perforation/holes", "Holes", ""},
      {"/metrics/perforation/area_mm2", "Area of the perforations", "mm²"}}},
    {"Force and torque",
     {{"/forces/peak_layer_axial_force_n", "Axial force, peak over a voxel of travel", "N"},
      {"/forces/peak_axial_force_n", "Axial force, peak of a single frame", "N"},
      {"/forces/mean_axial_force_n", "Axial force, mean", "N"},
      {"/forces/peak_layer_spin_torque_nmm", "Spin torque, peak over a voxel of travel", "N·mm"},
      {"/forces/peak_spin_torque_nmm", "Spin torque, peak of a single frame", "N·mm"},
      {"/forces/mean_spin_torque_nmm", "Spin torque, mean", "N·mm"},
      {"/forces/rms_force_n", "Force magnitude, RMS", "N"},
      {"/forces/rms_torque_nmm", "Torque magnitude, RMS", "N·mm"}}},
    {"Energy",
     {{"/work_mj", "Work done by the tool", "mJ"},
      {"/energy_mj", "Cutting energy", "mJ"},
      {"/friction_energy_mj", "Friction energy", "mJ"},
      {"/floor_energy_mj", "Speed-floor energy", "mJ"},
      {"/balance", "Energy balance, fraction of the cutting energy", ""}}},
    {"Motion",
     {{"/simulated_s", "Simulated time", "s"},
      {"/reaming_s", "Time in contact", "s"},
      {"/max_depth_mm", "Tool depth, since first contact", "mm"},
      {"/frames", "Frames", ""},
      {"/contact_frames", "Frames in contact", ""},
      {"/first_contact_frame", "First frame in contact", ""}}},
    {"Push",
     {{"/push/mean_feed_mm_s", "Feed rate from first contact on, mean", "mm/s"},
      {"/push/peak_feed_mm_s", "Feed rate in contact, peak", "mm/s"},
      {"/push/hand_work_mj", "Work of the hand", "mJ"},
      {"/push/drill_work_mj", "Work of the drive", "mJ"},
      {"/push/peak_hand_power_w", "Power of the hand, peak", "W"},
      {"/push/peak_drill_power_w", "Power of the drive, peak", "W"},
      {"/push/overshoot_mm", "Travel in 0.2 s after breakthrough", "mm"}}},
    {"Deflection",
     {{"/deflection/peak_mm", "Deflection of the springs, peak", "mm"},
      {"/deflection/peak_lateral_mm", "Across the axis, peak", "mm"},
      {"/deflection/lateral_at_depth_mm", "Across the axis, at the greatest depth", "mm"}}},
    {"Clearance",
     {{"/clearance/least_mm", "Least clearance of the holder", "mm"},
      {"/clearance/part", "Part of the holder", ""},
      {"/clearance/obstacle", "Nearest surface", ""},
      {"/clearance/frame", "Frame", ""},
      {"/clearance/time_s", "Time", "s"},
      {"/clearance/limit_mm", "Limit", "mm"},
      {"/clearance/first_frame_below", "First frame below the limit", ""},
      {"/clearance/last_frame_below", "Last frame below the limit", ""}}}};
constexpr ListTable kMeasuredLists[]{
    {"/push/events",
     "Events",
     "No.",
     {{"event", "Event", kText}, {"time_s", "Time, s", 3}, {"depth_mm", "Tool depth, mm", 2}, {"frame", "Frame", 0}}},
    {"/passes",
     "Passes",
     "Pass",
     {{"tool", "Reamer", kText},
      {"removed_mm3", "Removed, mm³"},
      {"max_depth_mm", "Tool depth, mm", 2},
      {"peak_axial_force_n", "Peak axial force, N"},
      {"peak_spin_torque_nmm", "Peak spin torque, N·mm", 0}}}};

constexpr Table kPlanning[]{{"Implant and joint line",
                             {{"/metrics/planning/native/version_deg", "Version, native face", "°"},
                              {"/metrics/planning/planned/version_deg", "Version, implant", "°"},
                              {"/metrics/planning/retroversion_corrected_deg", "Retroversion corrected", "°"},
                              {"/metrics/planning/native/inclination_deg", "Inclination, native face", "°"},
                              {"/metrics/planning/planned/inclination_deg", "Inclination, implant", "°"},
                              {"/metrics/planning/inclination_corrected_deg", "Inclination corrected", "°"},
                              {"/metrics/planning/corrected_frame", "Frame of the corrections", ""},
                              {"/metrics/planning/medialization_mm", "Medialization of the joint line", "mm"},
                              {"/metrics/planning/native_reason", "No native orientation", ""},
                              {"/metrics/planning/planned_reason", "No planned orientation", ""},
                              {"/metrics/planning/corrected_reason", "No correction", ""},
                              {"/metrics/planning/medialization_reason", "No medialization", ""}}},
                            {"Support of the implant",
                             {{"/metrics/seating/seated_percent", "Backside seated", "%"},
                              {"/metrics/seating/mean_gap_mm", "Gap under the implant, mean", "mm"},
                              {"/metrics/seating/max_gap_mm", "Gap under the implant, maximum", "mm"},
                              {"/metrics/seating/footprint_mm2", "Footprint", "mm²"},
                              {"/metrics/seating/overhang_mm2", "Overhang", "mm²"},
                              {"/metrics/seating/overhang_percent", "Overhang, of the footprint", "%"},
                              {"/metrics/seating/dense_percent", "Dense fraction of the supporting bone", "%"},
                              {"/metrics/seating/unreamed_mm2", "Footprint on unreamed bone", "mm²"},
                              {"/metrics/seating/held_off/gap_mm", "Held off by unreamed bone", "mm"},
                              {"/metrics/seating/held_off/area_mm2", "Unreamed bone that holds it off", "mm²"},
                              {"/metrics/planning/pegs_perforated", "Pegs that perforate", ""}}},
                            {"Vault",
                             {{"/metrics/planning/vault/left_mm3", "Vault bone under the implant", "mm³"},
                              {"/metrics/planning/vault/left_percent", "of the vault before reaming", "%"},
                              {"/metrics/planning/vault/axis_depth_mm", "Depth on the axis of the implant", "mm"},
                              {"/metrics/planning/vault/mean_depth_mm", "Depth, mean", "mm"}}}};
constexpr ListTable kPegs[]{{"/metrics/planning/pegs",
                             "Pegs",
                             "Peg",
                             {{"length_mm", "Length, mm"},
                              {"in_bone_mm", "In bone, mm"},
                              {"perforated_mm", "Perforated, mm"},
                              {"least_wall_mm", "Least wall, mm"}}}};

constexpr Line kProvenance[]{{"/program", "Program", ""},
                             {"/device", "Device", ""},
                             {"/engine", "Engine", ""},
                             {"/erosion", "Erosion", ""},
                             {"/law", "Force law", ""}};

std::string last_part(const std::string& path) {
  return path.substr(path.rfind('/') + 1);
}

/// A result file, whose values must have the types that a run or a verification writes.
class Results {
 public:
  Results(const Json& json, std::string path) : json_(json), path_(std::move(path)) {}

  [[nodiscard]] InputError wrong(const std::string& key, const std::string& expected) const {
    return {{path_, 0, 0}, key, "found another type", "expected " + expected};
  }

  /// The value at a pointer; null if missing.
  [[nodiscard]] Json at(const std::string& pointer) const {
    const Json::json_pointer at(pointer);
    return json_.contains(at) ? json_.at(at) : Json();
  }
  [[nodiscard]] std::string text(const char* key) const { return text_at(json_, key, path_); }
  [[nodiscard]] const Json& list(const char* key, const char* expected) const {
    if (!json_.contains(key) || !json_.at(key).is_array()) throw wrong(key, expected);
    return json_.at(key);
  }
  [[nodiscard]] std::optional<double> number(const std::string& pointer) const {
    const Json value = at(pointer);
    if (value.is_null()) return std::nullopt;
    if (!value.is_number()) throw wrong(pointer, "a number");
    return value.get<double>();
  }

  /// The rows of the values that are there.
  [[nodiscard]] Json rows(std::span<const Line> lines) const {
    Json out = Json::array();
    for (const Line& line : lines) {
      if (*line.only_with != '\0' && at(line.only_with).is_null()) continue;
      Json value = at(line.pointer);
      if (value.is_null()) continue;
      if (value.is_structured()) throw wrong(line.pointer, "a number");
      out.push_back(Json::array({line.label, std::move(value), line.unit}));
    }
    return out;
  }

  /// The tables that have a row.
  [[nodiscard]] Json tables(std::span<const Table> tables, std::span<const ListTable> lists) const {
    Json out = Json::array();
    for (const Table& table : tables) {
      if (Json rows = this->rows(table.lines); !rows.empty()) out.push_back({{"title", table.title}, {"rows", rows}});
    }
    for (const ListTable& list : lists) {
      const Json items = at(list.pointer);
      if (!items.is_null() && !items.empty()) out.push_back(this->items(list, items));
    }
    return out;
  }

 private:
  /// A row for each item, numbered as in the scenario.
  [[nodiscard]] Json items(const ListTable& list, const Json& items) const {
    Json out{{"title", list.title},
             {"columns", Json::array({list.item})},
             {"decimals", Json::array({0})},
             {"rows", Json::array()}};
    for (const ListColumn& column : list.columns) {
      out["columns"].push_back(column.title);
      out["decimals"].push_back(column.decimals == kText ? Json() : Json(column.decimals));
    }
    for (const Json& item : items) {
      Json row = Json::array({out["rows"].size() + 1});
      for (const ListColumn& column : list.columns) row.push_back(cell(item, list, column));
      out["rows"].push_back(std::move(row));
    }
    return out;
  }

  [[nodiscard]] Json cell(const Json& item, const ListTable& list, const ListColumn& column) const {
    if (!item.is_object() || !item.contains(column.key) || item.at(column.key).is_null()) return nullptr;
    const Json& value = item.at(column.key);
    const bool is_text = column.decimals == kText;
    if (!(is_text ? value.is_string() : value.is_number())) {
      throw wrong(std::string(list.pointer) + "/" + column.key, is_text ? "a text" : "a number");
    }
    return is_text ? Json(last_part(value.get<std::string>())) : value;
  }

  const Json& json_;
  std::string path_;
};

/// The headline figures, as in pictures and plots, then others.
Json key_figures(const Results& results) {
  KeyResults run{.means = from_name<ErosionMode>(results.text("erosion")) != ErosionMode::exact};
  Json out = Json::array();
  const auto add = [&](double& value, KeyResults::Figure (KeyResults::*figure)() const, const std::string& pointer,
                       const std::string& earlier) {
    auto number = results.number(pointer);
    if (!number) number = results.number(earlier);
    if (!number) return;
    value = *number;
    const auto [name, text, unit] = (run.*figure)();
    out.push_back(Json::array({name, text, unit}));
  };
  // Earlier versions wrote these numbers without the section "headline".
  const std::string peak = run.means ? "/forces/peak_layer_" : "/forces/peak_";
  add(run.tool_depth_mm, &KeyResults::depth, "/headline/depth_mm", "/max_depth_mm");
  add(run.peak_axial_force_n, &KeyResults::force, "/headline/peak_axial_force_n", peak + "axial_force_n");
  add(run.peak_spin_torque_nmm, &KeyResults::torque, "/headline/peak_spin_torque_nmm", peak + "spin_torque_nmm");
  for (Json& row : results.rows(kKeyFigures)) out.push_back(std::move(row));
  return out;
}

Json warnings(const Results& results) {
  const Json& out = results.list("warnings", "a list");
  for (const Json& warning : out) {
    if (!warning.is_string()) throw results.wrong("warnings", "a list of texts");
  }
  return out;
}

Json provenance(const Results& results, const std::string& path) {
  for (const Line& line : kProvenance) (void)results.text(line.pointer + 1);  // throws where one is missing
  Json inputs{{"title", "Inputs"}, {"columns", Json::array({"Key", "File", "SHA-256"})}, {"rows", Json::array()}};
  for (const Json& input : results.list("inputs", "a list of files")) {
    inputs["rows"].push_back(Json::array(
        {text_at(input, "role", path), last_part(text_at(input, "path", path)), text_at(input, "sha256", path)}));
  }
  Json settings{{"title", "Program and settings"}, {"rows", results.rows(kProvenance)}};
  return Json::array({std::move(settings), std::move(inputs)});
}

Json verification_data(const Results& results, const Json& verification, const std::string& path) {
  if (verification.is_null()) return nullptr;
  const Results verified(verification, path);
  const Json passed = verified.at("/passed"), cases = verified.at("/cases");
  if (!passed.is_boolean() || !cases.is_array())
    throw verified.wrong("passed", "the verification.json of reamsim verify");
  Json out{{"passed", passed}, {"suite", verified.text("suite")}, {"cases", cases.size()}};
  out["differs"] = Json::array();
  for (const char* key : {"program", "device"}) {
    out[key] = verified.text(key);
    if (out[key] != results.text(key)) out["differs"].push_back(key);
  }
  return out;
}

}  // namespace

std::string text_at(const Json& json, const char* key, const std::string& path) {
  if (!json.contains(key) || !json.at(key).is_string()) throw Results(json, path).wrong(key, "a text");
  return json.at(key).get<std::string>();
}

Json summary_data(const Json& summary, const Json& verification, const std::string& summary_path,
                  const std::string& verification_path) {
  const Results results(summary, summary_path);
  return {{"warnings", warnings(results)},
          {"key_figures", key_figures(results)},
          {"planning", results.tables(kPlanning, kPegs)},
          {"measurements", results.tables(kMeasurements, kMeasuredLists)},
          {"balance", results.rows(std::array{Line{"/balance", "", ""}})},
          {"verification", verification_data(results, verification, verification_path)},
          {"provenance", provenance(results, summary_path)}};
}

}  // namespace reamsim
