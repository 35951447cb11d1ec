// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/viewer/report.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <span>
#include <vector>

#include "render/plots/plots.h"
#include "render/viewer/page.h"
#include "render/viewer/report_data.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/record/result_json.h"

namespace reamsim {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

/// About the horizontal resolution of a screen.
constexpr std::size_t kMaxBuckets = 1000;

Json read_json(const std::string& path, const std::string& expected) {
  Json json = parse_result_json(read_file(path, expected));
  if (!json.is_object()) throw InputError({path, 0, 0}, "", "is not a JSON object", expected);
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
  const auto text = [&](const char* key) { return text_at(summary, key, summary_path); };
  const std::string title = text("scenario"), program = text("program");
  const Json tables = summary_data(summary, verification, summary_path, verification_path);
  PageTexts texts{{"device", escape_html(text("device"))},
                  {"plain", plain_html(tables)},
                  {"printed_plot", printed_plot_html(dir)},
                  {"scenario", escape_html(read_file(dir + "/scenario.yaml", "the scenario.yaml of a run"))},
                  {"bone_figure", ""},  // the first picture: in place of the 3D view on paper and without JavaScript
                  {"figures", ""}};
  // The slow parts come last, after the checks of the others.
  const auto figures = figures_html(dir, name_of(options.settings.cameras.front()));
  for (std::size_t i = 0; i < figures.size(); ++i) texts[i == 0 ? "bone_figure" : "figures"] += figures[i];
  Json data = script_data(run, options);
  data["summary"] = tables;
  return self_contained_page(embedded::report_page, title, program, data, std::move(texts));
}

}  // namespace

std::vector<std::size_t> shown_rows(const std::vector<ForceRow>& rows) {
  const std::size_t bucket = 1 + (rows.size() - 1) / kMaxBuckets;
  std::vector<std::size_t> out;
  const auto force = [](const ForceRow& row) { return row.axial_force_n; };
  const auto torque = [](const ForceRow& row) { return row.spin_torque_nmm; };
  const auto feed = [](const ForceRow& row) { return row.push.value_or(PushResult{}).feed_mm_s; };
  for (std::size_t from = 0; from < rows.size(); from += bucket) {
    const auto group = std::span(rows).subspan(from, std::min(bucket, rows.size() - from));
    std::set<std::size_t> chosen{from};
    const auto choose_extremes = [&](const auto& value) {
      const auto [least, most] = std::ranges::minmax_element(group, {}, value);
      chosen.insert({from + static_cast<std::size_t>(least - group.begin()),
                     from + static_cast<std::size_t>(most - group.begin())});
    };
    choose_extremes(force);
    choose_extremes(torque);
    choose_extremes(feed);
    out.insert(out.end(), chosen.begin(), chosen.end());
  }
  if (out.back() != rows.size() - 1) out.push_back(rows.size() - 1);
  return out;
}

nlohmann::ordered_json plot_data(const ForceLog& log, double mean_travel_mm) {
  nlohmann::ordered_json json{{"mean_travel_mm", mean_travel_mm}};
  const std::vector<std::size_t> shown = shown_rows(log.rows);
  const auto column = [&](const char* name, double ForceRow::*value) {
    auto& values = json[name] = nlohmann::ordered_json::array();
    for (const std::size_t i : shown) values.push_back(short_number(log.rows[i].*value));
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
    for (const std::size_t i : shown) {
      const PushResult push = log.rows[i].push.value_or(PushResult{});
      json["feed_mm_s"].push_back(short_number(push.feed_mm_s));
      json["drill_power_w"].push_back(short_number(push.drill_power_w));
    }
  }
  return json;
}

void write_report(const RunData& run, const PictureOptions& options) {
  if (options.settings.cameras.empty()) {
    throw InputError({}, "render.cameras", "found none", "expected at least one camera");
  }
  write_file(run.dir() + "/report.html", page_html(run, options));
}

}  // namespace reamsim
