// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/args.h>
#include <fmt/core.h>
#include <algorithm>
#include <optional>
#include <set>

#include "sim/base/text.h"
#include "sim/bench/paper.h"
#include "sim/bench/suite.h"

namespace reamsim::bench {

namespace {

using Lines = std::vector<std::vector<std::string>>;

/// The lines under a title, with the head underlined; "" where there is only the head.
std::string table_text(const std::string& title, const Lines& cells) {
  if (cells.size() < 2) return "";
  std::vector<std::string> lines = align_columns(cells);
  lines.insert(lines.begin() + 1, std::string(text_width(lines[0]), '-'));
  std::string out = title + "\n";
  for (const std::string& line : lines) out += "  " + line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  return out + "\n";
}

Label label(const Json& row) {
  return {row["engine"], row["variant"]};
}

/// A column of a table: its head, and how a cell shows the values of some keys of a row. Without keys: the program.
struct Column {
  const char* head;
  const char* format;
  std::vector<const char*> keys;
  double scale = 1;
};

std::string cell_of(const Json& row, const Column& column) {
  if (column.keys.empty()) return name_of(label(row));
  fmt::dynamic_format_arg_store<fmt::format_context> values;
  for (const char* key : column.keys) {
    if (row[key].is_null()) return "–";
    if (row[key].is_number()) {
      values.push_back(column.scale * row[key].get<double>());
    } else {
      values.push_back(row[key].get<std::string>());
    }
  }
  return fmt::vformat(column.format, values);
}

std::string table_text(const std::string& title, const Json& rows, const std::vector<Column>& columns) {
  Lines cells(1);
  for (const Column& column : columns) cells[0].push_back(column.head);
  for (const Json& row : rows) {
    cells.emplace_back();
    for (const Column& column : columns) cells.back().push_back(cell_of(row, column));
  }
  return table_text(title, cells);
}

const Column kProgram{"engine", "", {}}, kRange{"min – max", "{:.3f} – {:.3f}", {"min_ms", "max_ms"}};

std::string cube(int side) {
  return std::to_string(side) + "³";
}

/// "measured (paper)" in the paper's unit.
std::string beside(std::optional<double> measured, std::optional<double> paper) {
  const auto number = [](std::optional<double> value) { return value ? fmt::format("{:.2f}", *value) : "–"; };
  return number(measured) + " (" + number(paper) + ")";
}

/// The value of a row's key; none where it is null.
std::optional<double> value(const Json& row, const char* key) {
  return row[key].is_null() ? std::nullopt : std::optional(row[key].get<double>());
}

/// The programs of the results, in their order.
std::vector<Label> labels_of(const Json& report) {
  std::vector<Label> out;
  for (const Json& row : report["results"]) {
    if (std::ranges::count(out, label(row)) == 0) out.push_back(label(row));
  }
  return out;
}

std::set<int> sizes_of(const Json& report, const char* key) {
  std::set<int> sizes;
  for (const Json& row : report["results"]) sizes.insert(row[key].get<int>());
  return sizes;
}

/// Tables 1, 3 and 5: severe contact by voxmap (rows) and shell (columns).
std::string severe_table(const Json& report, const Label& who) {
  const bool no_shell = who.engine == "implicit";
  std::set<int> shells = sizes_of(report, "shell");
  if (no_shell) shells.erase(shells.begin(), std::prev(shells.end()));
  Lines table{{"voxmap \\ shell"}};
  for (const int shell : shells) table[0].push_back(no_shell ? "no shell" : cube(shell));
  for (const int voxmap : sizes_of(report, "voxmap")) {
    table.push_back({cube(voxmap)});
    for (const int shell : shells) {
      const Json* row = find_result(report, who, voxmap, shell, "severe");
      const auto measured = row != nullptr ? value(*row, "median_ms") : std::nullopt;
      table.back().push_back(beside(measured, paper_ms(who.engine, voxmap, shell)));
    }
  }
  const char* const source = who.engine == "octree" ? "Table 3" : no_shell ? "Table 5" : "Table 1";
  return table_text(name_of(who) + ", severe contact, whole frame, ms (the paper's " + source + ")", table);
}

std::string cases_table(const Json& report) {
  return table_text(
      "Every case: a frame alone, broad phase to results read; plunge in batches of 64. exact: whole frames at 1 mm/s "
      "with "
      "the rows of forces.csv, by window of 64; contacts: voxels that lose bone",
      report["results"],
      {kProgram,
       {"voxmap", "{}³", {"voxmap"}},
       {"shell", "{}³", {"shell"}},
       {"case", "{}", {"case"}},
       {"contacts", "{:.0f}", {"contacts"}},
       {"median ms", "{:.3f}", {"median_ms"}},
       kRange,
       {"kernel ms", "{:.3f}", {"kernel_ms"}},
       {"published direct / this", "{:.2f}", {"ratio_to_direct"}}});
}

std::string phases_table(const Json& report) {
  const Json& phases = report["phases"];
  if (phases.empty()) return "";
  // Table 2, both 1024³, 103,000 contacts, µs.
  Json rows = Json::array({Json{{"engine", "the paper"},
                                {"variant", ""},
                                {"obb_us", 0.77},
                                {"voi_us", 0.26},
                                {"upload_us", 169.9},
                                {"kernel_us", 568.72},
                                {"read_us", 71.03},
                                {"total_us", 810.67}}});
  for (const Json& row : phases) {
    if (row["voxmap"] == phases.back()["voxmap"] && row["shell"] == phases.back()["shell"]) rows.push_back(row);
  }
  return table_text("Phases (Table 2)", rows,
                    {{"both at the largest, severe, µs", "", {}},
                     {"OBB–OBB", "{:.2f}", {"obb_us"}},
                     {"VOI", "{:.2f}", {"voi_us"}},
                     {"to device", "{:.1f}", {"upload_us"}},
                     {"kernels", "{:.1f}", {"kernel_us"}},
                     {"rest, read-back", "{:.1f}", {"read_us"}},
                     {"total", "{:.1f}", {"total_us"}}});
}

std::optional<double> paper_mb(const double (&table)[5][2], int side, const std::string& engine) {
  const auto row = place(kShells, side);
  if (!row || (engine != "direct" && engine != "octree")) return std::nullopt;
  const double mb = table[*row][engine == "octree" ? 1 : 0];
  return mb < 0 ? std::nullopt : std::optional(mb);
}

std::string memory_table(const Json& report) {
  Lines table{{"engine", "voxmap", "MB", "shell", "MB"}};
  std::set<std::pair<std::string, int>> shown;
  for (const Json& row : report["memory"]) {
    const std::string engine = row["engine"];
    const int voxmap = row["voxmap"], shell = row["shell"];
    // The two structures do not depend on each other: each size once.
    const bool new_voxmap = shown.insert({engine, voxmap}).second;
    const bool new_shell = shown.insert({engine, -shell}).second;
    if (!new_voxmap && !new_shell) continue;
    table.push_back({engine, new_voxmap ? cube(voxmap) : "",
                     new_voxmap ? beside(value(row, "voxmap_mb"), paper_mb(kPaperVoxmapMb, voxmap, engine)) : "",
                     new_shell ? cube(shell) : "",
                     new_shell ? beside(value(row, "shell_mb"), paper_mb(kPaperShellMb, shell, engine)) : ""});
  }
  return table_text("Memory on the device, MB = 10⁶ bytes (Table 4)", table);
}

std::string voi_table(const Json& report) {
  Json rows = report["voi"];
  for (Json& row : rows) row["saved"] = 1 - row["with_ms"].get<double>() / row["without_ms"].get<double>();
  return table_text("VOI (Fig. 8; the paper saves almost 50 % in glenoid reaming)", rows,
                    {{"VOI / tool's box", "{:.0f} %", {"fraction"}, 100},
                     kProgram,
                     {"contacts", "{:.0f}", {"contacts"}},
                     {"with VOI ms", "{:.3f}", {"with_ms"}},
                     {"without ms", "{:.3f}", {"without_ms"}},
                     {"saved", "{:.0f} %", {"saved"}, 100}});
}

std::string batches_table(const Json& report) {
  return table_text("Frames enqueued together", report["batches"],
                    {kProgram,
                     {"case", "{}", {"case"}},
                     {"frames at once", "{}", {"batch"}},
                     {"ms per frame", "{:.3f}", {"median_ms"}},
                     kRange});
}

std::string scatter_table(const Json& report) {
  return table_text("Effect of races: one severe frame repeated (± standard deviation)", report["scatter"],
                    {kProgram,
                     {"voxmap", "{}³", {"voxmap"}},
                     {"points", "{:.0f}", {"points"}},
                     {"in voxels", "{:.0f}", {"voxels"}},
                     {"counted", "{:.0f}", {"contacts_median"}},
                     {"min – max", "{:.0f} – {:.0f}", {"contacts_min", "contacts_max"}},
                     {"contacts ±", "{:.3f} %", {"contacts_spread"}, 100},
                     {"force ±", "{:.3f} %", {"force_spread"}, 100},
                     {"component ±", "{:.3f} %", {"component_spread"}, 100}});
}

std::string spheres_table(const Json& report) {
  return table_text(
      "A sphere of 29 mm radius plunged 4 mm at 0.2 mm/s and 1 kHz, timed at four depths. exact: at each 256 whole "
      "frames with the rows of forces.csv, by window of 64; others: 16 frames from the pose to the sums",
      report["spheres"],
      {{"engine", "{}", {"engine"}},
       {"erosion", "{}", {"erosion"}},
       {"voxel mm", "{:g}", {"voxel_mm"}},
       {"ms per frame", "{:.4f}", {"median_ms"}},
       kRange,
       {"times real time", "{:.1f}", {"times_real_time"}},
       {"kernels ms", "{:.4f}", {"kernel_ms"}},
       {"one core ms", "{:.4f}", {"one_core_ms"}},
       {"removed mm³", "{:.1f}", {"removed_mm3"}},
       {"volume error", "{:+.5f} %", {"volume_error"}, 100}});
}

/// How far the kernels of `exact` are from what the device does at most.
std::string limits_table(const Json& report) {
  const Json& peaks = report["peaks"];
  if (peaks.is_null()) return "";
  const double gops = peaks["gops"], gb_s = peaks["gb_s"];
  Json rows = Json::array();
  for (const Json& row : report["spheres"]) {
    if (row["voxels"].is_null()) continue;
    const double voxels = row["voxels"], operations = kExactOperations * voxels, bytes = kExactBytes * voxels;
    const double arithmetic_ms = 1e-6 * operations / gops, memory_ms = 1e-6 * bytes / gb_s;
    rows.push_back(row);
    rows.back().update({{"operations", 1e-6 * operations},
                        {"arithmetic_ms", arithmetic_ms},
                        {"kb", 1e-3 * bytes},
                        {"memory_ms", memory_ms},
                        {"fraction", std::max(arithmetic_ms, memory_ms) / row["kernel_ms"].get<double>()}});
  }
  return table_text(fmt::format("exact against this device: {:.0f}·10⁹ operations/s (fused multiply-adds, two each), "
                                "{:.1f} GB/s (copy); {:.0f} operations and {:.2f} bytes per voxel and frame",
                                gops, gb_s, kExactOperations, kExactBytes),
                    rows,
                    {{"voxel mm", "{:g}", {"voxel_mm"}},
                     {"voxels per frame", "{:.0f}", {"voxels"}},
                     {"10⁶ operations", "{:.2f}", {"operations"}},
                     {"at the peak ms", "{:.4f}", {"arithmetic_ms"}},
                     {"kB", "{:.1f}", {"kb"}},
                     {"at the peak ms", "{:.5f}", {"memory_ms"}},
                     {"kernels ms", "{:.4f}", {"kernel_ms"}},
                     {"fraction of the limit", "{:.1f} %", {"fraction"}, 100}});
}

std::string head(const Json& report) {
  std::string out = fmt::format(
      "reamsim " REAMSIM_VERSION
      " bench on {} ({}, {} compute units); in brackets: the paper's figure on a GTX 970\nmedians of {} repetitions of "
      "each of 4 poses, after a warm-up, engines alternating\nshells:",
      report["device"].get<std::string>(), report["driver"].get<std::string>(), report["compute_units"].get<unsigned>(),
      report["repetitions"].get<int>());
  for (const Json& row : report["shells"]) {
    out += fmt::format(" {} {} points;", cube(row["shell"]), row["points"].get<std::size_t>());
  }
  out.back() = '\n';
  if (!report["poses"].empty()) out += "points touching at the largest, by pose:";
  for (const Json& pose : report["poses"]) {
    out += (pose["pose"] == 0 ? "  " + pose["case"].get<std::string>() + " " : ", ") +
           std::to_string(pose["points"].get<std::int64_t>());
  }
  return out + "\n\n";
}

std::string skipped_list(const Json& report) {
  if (report["skipped"].empty()) return "";
  std::string out = "Not measured\n";
  for (const Json& row : report["skipped"]) {
    out += fmt::format("  {}, voxmap {}, shell {}, {}: {}\n", name_of(label(row)), cube(row["voxmap"]),
                       cube(row["shell"]), row["case"].get<std::string>(), row["reason"].get<std::string>());
  }
  return out + "\n";
}

}  // namespace

std::string text_of(const Json& report) {
  std::string out = head(report);
  for (const Label& who : labels_of(report)) {
    if (who.engine != "exact") out += severe_table(report, who);
  }
  for (const auto table : {phases_table, memory_table, voi_table, batches_table, scatter_table, spheres_table,
                           limits_table, cases_table, skipped_list}) {
    out += table(report);
  }
  return out + fmt::format("took {:.0f} s\n", report["seconds"].get<double>());
}

}  // namespace reamsim::bench
