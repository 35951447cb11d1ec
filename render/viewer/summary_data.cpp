// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <optional>

#include "render/viewer/page.h"
#include "sim/base/error.h"
#include "sim/record/run_totals.h"
#include "sim/scenario/choices.h"

namespace reamsim {
namespace embedded {
extern const char* const report_tables;
}
namespace {

using Json = nlohmann::ordered_json;

/// What the report shows of summary.json. A row has the JSON pointer of a value, its label, its unit, and optionally
/// the pointer of a value without which the row is left out. A table with "list" has a row for each item of that list,
/// numbered from 1 under "item". A column has its key in the item, its title, and its decimals: null for a text, of
/// which the part after the last '/' is shown.
const Json& shown(const char* part) {
  static const Json tables = Json::parse(embedded::report_tables);
  return tables.at(part);
}

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
  [[nodiscard]] Json rows(const Json& lines) const {
    Json out = Json::array();
    for (const Json& line : lines) {
      if (line.size() > 3 && at(line[3]).is_null()) continue;
      Json value = at(line[0]);
      if (value.is_null()) continue;
      if (value.is_structured()) throw wrong(line[0], "a number");
      out.push_back(Json::array({line[1], std::move(value), line[2]}));
    }
    return out;
  }

  /// The tables that have a row.
  [[nodiscard]] Json tables(const Json& tables) const {
    Json out = Json::array();
    for (const Json& table : tables) {
      Json made =
          table.contains("list") ? items(table) : Json{{"title", table["title"]}, {"rows", rows(table["rows"])}};
      if (!made["rows"].empty()) out.push_back(std::move(made));
    }
    return out;
  }

 private:
  /// A row for each item of a list, numbered as in the scenario.
  [[nodiscard]] Json items(const Json& table) const {
    Json out{{"title", table["title"]},
             {"columns", Json::array({table["item"]})},
             {"decimals", Json::array({0})},
             {"rows", Json::array()}};
    for (const Json& column : table["columns"]) {
      out["columns"].push_back(column[1]);
      out["decimals"].push_back(column[2]);
    }
    const Json list = at(table["list"]);
    if (!list.is_null() && !list.is_array()) throw wrong(table["list"], "a list");
    for (const Json& item : list) {
      Json row = Json::array({out["rows"].size() + 1});
      for (const Json& column : table["columns"]) row.push_back(cell(item, table["list"], column));
      out["rows"].push_back(std::move(row));
    }
    return out;
  }

  [[nodiscard]] Json cell(const Json& item, const std::string& list, const Json& column) const {
    const std::string key = column[0];
    if (!item.is_object() || !item.contains(key) || item.at(key).is_null()) return nullptr;
    const Json& value = item.at(key);
    const bool is_text = column[2].is_null();
    if (!(is_text ? value.is_string() : value.is_number())) {
      throw wrong(list + "/" + key, is_text ? "a text" : "a number");
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
  for (Json& row : results.rows(shown("key_figures"))) out.push_back(std::move(row));
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
  for (const char* key : {"program", "device", "engine", "erosion", "law"})
    (void)results.text(key);  // throws if missing
  Json inputs{{"title", "Inputs"}, {"columns", Json::array({"Key", "File", "SHA-256"})}, {"rows", Json::array()}};
  for (const Json& input : results.list("inputs", "a list of files")) {
    inputs["rows"].push_back(Json::array(
        {text_at(input, "role", path), last_part(text_at(input, "path", path)), text_at(input, "sha256", path)}));
  }
  Json settings{{"title", "Program and settings"}, {"rows", results.rows(shown("provenance"))}};
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
          {"planning", results.tables(shown("planning"))},
          {"measurements", results.tables(shown("measurements"))},
          {"balance", results.rows(Json::array({Json::array({"/balance", "", ""})}))},
          {"verification", verification_data(results, verification, verification_path)},
          {"provenance", provenance(results, summary_path)}};
}

}  // namespace reamsim
