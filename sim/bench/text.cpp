// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <algorithm>
#include <optional>
#include <set>

#include "sim/base/text.h"
#include "sim/bench/paper.h"
#include "sim/bench/suite.h"

namespace reamsim::bench {

namespace {

using Rows = std::vector<std::vector<std::string>>;

/// The rows under a title, with the head underlined; "" where there is only the head.
std::string table_text(const std::string& title, const Rows& rows) {
  if (rows.size() < 2) return "";
  std::vector<std::string> lines = align_columns(rows);
  lines.insert(lines.begin() + 1, std::string(text_width(lines[0]), '-'));
  std::string out = title + "\n";
  for (const std::string& line : lines) out += "  " + line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  return out + "\n";
}

std::string cube(int side) {
  return std::to_string(side) + "³";
}

std::string number(std::optional<double> value, int decimals) {
  return value ? fmt::format("{:.{}f}", *value, decimals) : "–";
}

std::string percent(double fraction, int decimals) {
  return fmt::format("{:.{}f} %", 100 * fraction, decimals);
}

/// "measured (paper)" in the paper's unit.
std::string beside(std::optional<double> measured, std::optional<double> paper) {
  return number(measured, 2) + " (" + number(paper, 2) + ")";
}

std::string range(double min, double max, int decimals = 3) {
  return number(min, decimals) + " – " + number(max, decimals);
}

/// The value of a row's key; none where it is null.
std::optional<double> value(const Json& row, const char* key) {
  return row[key].is_null() ? std::nullopt : std::optional(row[key].get<double>());
}

Label label(const Json& row) {
  return {row["engine"], row["variant"]};
}

/// The labels of the case rows, in their order.
std::vector<Label> labels_of(const Findings& findings) {
  std::vector<Label> out;
  for (const CaseRow& row : findings.cases) {
    const auto same = [&](const Label& l) { return name_of(l) == name_of(row.at.who); };
    if (std::none_of(out.begin(), out.end(), same)) out.push_back(row.at.who);
  }
  return out;
}

template <class Member>
std::vector<int> sizes_of(const Findings& findings, Member member) {
  std::set<int> sizes;
  for (const CaseRow& row : findings.cases) sizes.insert(row.at.*member);
  return {sizes.begin(), sizes.end()};
}

/// Tables 1, 3 and 5: severe contact by voxmap (rows) and shell (columns).
std::string severe_table(const Findings& findings, const Label& who) {
  const std::vector<int> shells = sizes_of(findings, &Place::shell);
  std::vector<std::string> head{"voxmap \\ shell"};
  const bool no_shell = who.engine == "implicit";
  for (const int shell : shells) {
    if (!no_shell) head.push_back(cube(shell));
  }
  if (no_shell) head.push_back("no shell");
  Rows table{head};
  for (const int voxmap : sizes_of(findings, &Place::voxmap)) {
    std::vector<std::string> cells{cube(voxmap)};
    for (const int shell : shells) {
      if (no_shell && shell != shells.back()) continue;
      const CaseRow* row = findings.find(who, voxmap, shell, "severe");
      const auto measured = row != nullptr ? std::optional(row->ms.median) : std::nullopt;
      cells.push_back(beside(measured, paper_ms(who.engine, voxmap, shell)));
    }
    table.push_back(cells);
  }
  const char* const source = who.engine == "octree" ? "Table 3" : no_shell ? "Table 5" : "Table 1";
  return table_text(name_of(who) + ", severe contact, whole frame, ms (the paper's " + source + ")", table);
}

std::string cases_table(const Findings& findings) {
  Rows table{{"engine", "voxmap", "shell", "case", "contacts", "median ms", "min – max", "kernel ms",
              "published direct / this"}};
  for (const CaseRow& row : findings.cases) {
    table.push_back({name_of(row.at.who), cube(row.at.voxmap), cube(row.at.shell), row.at.contact,
                     number(row.contacts, 0), number(row.ms.median, 3), range(row.ms.min, row.ms.max),
                     number(row.kernel_ms, 3), number(row.ratio_to_direct, 2)});
  }
  return table_text(
      "Every case: a frame alone, broad phase to results read; plunge in batches of 64. exact: whole frames at 1 mm/s "
      "with "
      "the rows of forces.csv, by window of 64; contacts: voxels that lose bone",
      table);
}

std::string phases_table(const Findings& findings) {
  const PaperPhases paper;
  Rows table{{"both at the largest, severe, µs", "OBB–OBB", "VOI", "to device", "kernels", "rest, read-back", "total"}};
  table.push_back({"the paper", number(paper.obb, 2), number(paper.voi, 2), number(paper.upload, 1),
                   number(paper.kernel, 1), number(paper.read, 1), number(paper.total, 1)});
  if (findings.phases.empty()) return "";
  const Json& last = findings.phases.back();
  for (const Json& row : findings.phases) {
    if (row["voxmap"] != last["voxmap"] || row["shell"] != last["shell"]) continue;
    table.push_back({name_of(label(row)), number(value(row, "obb_us"), 2), number(value(row, "voi_us"), 2),
                     number(value(row, "upload_us"), 1), number(value(row, "kernel_us"), 1),
                     number(value(row, "read_us"), 1), number(value(row, "total_us"), 1)});
  }
  return table_text("Phases (Table 2)", table);
}

std::optional<double> paper_mb(const double (&table)[5][2], int side, const std::string& engine) {
  const auto row = place(kShells, side);
  if (!row || (engine != "direct" && engine != "octree")) return std::nullopt;
  const double mb = table[*row][engine == "octree" ? 1 : 0];
  return mb < 0 ? std::nullopt : std::optional(mb);
}

std::string memory_table(const Findings& findings) {
  Rows table{{"engine", "voxmap", "MB", "shell", "MB"}};
  std::set<std::pair<std::string, int>> shown;
  for (const Json& row : findings.memory) {
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

std::string voi_table(const Findings& findings) {
  Rows table{{"VOI / tool's box", "engine", "contacts", "with VOI ms", "without ms", "saved"}};
  for (const Json& row : findings.voi) {
    const double with_ms = row["with_ms"], without_ms = row["without_ms"];
    table.push_back({percent(row["fraction"], 0), name_of(label(row)), number(value(row, "contacts"), 0),
                     number(with_ms, 3), number(without_ms, 3), percent(1 - with_ms / without_ms, 0)});
  }
  return table_text("VOI (Fig. 8; the paper saves almost 50 % in glenoid reaming)", table);
}

std::string batches_table(const Findings& findings) {
  Rows table{{"engine", "case", "frames at once", "ms per frame", "min – max"}};
  for (const Json& row : findings.batches) {
    table.push_back({name_of(label(row)), row["case"], std::to_string(row["batch"].get<int>()),
                     number(value(row, "median_ms"), 3), range(row["min_ms"], row["max_ms"])});
  }
  return table_text("Frames enqueued together", table);
}

std::string scatter_table(const Findings& findings) {
  Rows table{
      {"engine", "voxmap", "points", "in voxels", "counted", "min – max", "contacts ±", "force ±", "component ±"}};
  for (const Json& row : findings.scatter) {
    table.push_back({name_of(label(row)), cube(row["voxmap"]), number(value(row, "points"), 0),
                     number(value(row, "voxels"), 0), number(value(row, "contacts_median"), 0),
                     range(row["contacts_min"], row["contacts_max"], 0), percent(row["contacts_spread"], 3),
                     percent(row["force_spread"], 3), percent(row["component_spread"], 3)});
  }
  return table_text("Effect of races: one severe frame repeated (± standard deviation)", table);
}

std::string spheres_table(const Findings& findings) {
  Rows table{{"engine", "erosion", "voxel mm", "ms per frame", "min – max", "times real time", "kernels ms",
              "one core ms", "removed mm³", "volume error"}};
  for (const SphereRow& row : findings.spheres) {
    const ExactFrames exact = row.exact.value_or(ExactFrames{});
    table.push_back({row.engine, name_of(row.erosion), fmt::format("{:g}", row.voxel_mm), number(row.ms.median, 4),
                     range(row.ms.min, row.ms.max), number(row.times_real_time(), 1),
                     number(row.exact ? std::optional(exact.kernel_ms) : std::nullopt, 4),
                     number(exact.one_core_ms ? std::optional(exact.one_core_ms->median) : std::nullopt, 4),
                     number(row.removed_mm3, 1), fmt::format("{:+.5f} %", 100 * row.volume_error)});
  }
  return table_text(
      "A sphere of 29 mm radius plunged 4 mm at 0.2 mm/s and 1 kHz, timed at four depths. exact: at each 256 whole "
      "frames with the rows of forces.csv, by window of 64; others: 16 frames from the pose to the sums",
      table);
}

/// How far the kernels of `exact` are from what the device does at most.
std::string limits_table(const Findings& findings) {
  if (!findings.peaks) return "";
  const MachinePeaks& peaks = *findings.peaks;
  Rows table{{"voxel mm", "voxels per frame", "10⁶ operations", "at the peak ms", "kB", "at the peak ms", "kernels ms",
              "fraction of the limit"}};
  for (const SphereRow& row : findings.spheres) {
    if (!row.exact) continue;
    const double operations = kExactOperations * row.exact->voxels, bytes = kExactBytes * row.exact->voxels;
    const double arithmetic_ms = 1e-6 * operations / peaks.gops, memory_ms = 1e-6 * bytes / peaks.gb_s;
    table.push_back({fmt::format("{:g}", row.voxel_mm), number(row.exact->voxels, 0), number(1e-6 * operations, 2),
                     number(arithmetic_ms, 4), number(1e-3 * bytes, 1), number(memory_ms, 5),
                     number(row.exact->kernel_ms, 4),
                     percent(std::max(arithmetic_ms, memory_ms) / row.exact->kernel_ms, 1)});
  }
  return table_text(fmt::format("exact against this device: {:.0f}·10⁹ operations/s (fused multiply-adds, two each), "
                                "{:.1f} GB/s (copy); {:.0f} operations and {:.2f} bytes per voxel and frame",
                                peaks.gops, peaks.gb_s, kExactOperations, kExactBytes),
                    table);
}

std::string head(const Findings& findings) {
  std::string out = fmt::format(
      "reamsim " REAMSIM_VERSION
      " bench on {} ({}, {} compute units); in brackets: the paper's figure on a GTX 970\nmedians of {} repetitions of "
      "each of 4 poses, after a warm-up, engines alternating\nshells:",
      findings.device, findings.driver, findings.compute_units, findings.repetitions);
  for (const auto& [shell, points] : findings.shell_points) {
    out += " " + cube(shell) + " " + std::to_string(points) + " points;";
  }
  out.back() = '\n';
  if (!findings.poses.empty()) out += "points touching at the largest, by pose:";
  for (const Json& pose : findings.poses) {
    out += (pose["pose"] == 0 ? "  " + pose["case"].get<std::string>() + " " : ", ") +
           std::to_string(pose["points"].get<std::int64_t>());
  }
  return out + "\n\n";
}

std::string skipped_list(const Findings& findings) {
  if (findings.skipped.empty()) return "";
  std::string out = "Not measured\n";
  for (const Skipped& row : findings.skipped) {
    out += fmt::format("  {}, voxmap {}³, shell {}³, {}: {}\n", name_of(row.at.who), row.at.voxmap, row.at.shell,
                       row.at.contact, row.reason);
  }
  return out + "\n";
}

}  // namespace

std::string text_of(const Findings& findings) {
  std::string out = head(findings);
  for (const Label& who : labels_of(findings)) {
    if (who.engine != "exact") out += severe_table(findings, who);
  }
  out += phases_table(findings) + memory_table(findings) + voi_table(findings) + batches_table(findings) +
         scatter_table(findings) + spheres_table(findings) + limits_table(findings) + cases_table(findings) +
         skipped_list(findings);
  return out + fmt::format("took {:.0f} s\n", findings.seconds);
}

}  // namespace reamsim::bench
