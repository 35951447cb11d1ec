#include <fmt/core.h>
#include <algorithm>
#include <set>

#include "sim/bench/findings.h"
#include "sim/bench/paper.h"
#include "sim/bench/text_table.h"

namespace reamsim::bench {

namespace {

std::string name(const Label& who) {
  return who.engine + (who.variant == "published" ? ", published" : "");
}

std::string cube(int side) {
  return std::to_string(side) + "³";
}

/// "measured (paper)" in the paper's unit.
std::string beside(const std::string& measured, std::optional<double> paper, fmt::format_string<double&> pattern) {
  return measured + " (" + (paper ? fmt::format(pattern, *paper) : "–") + ")";
}

std::string range(const Spread& ms) {
  return fmt::format("{:.3f}", ms.min) + " – " + fmt::format("{:.3f}", ms.max);
}

/// The labels of the case rows, in their order.
std::vector<Label> labels_of(const Findings& findings) {
  std::vector<Label> out;
  for (const CaseRow& row : findings.cases) {
    const auto same = [&](const Label& l) { return name(l) == name(row.at.who); };
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
  TextTable table;
  std::vector<std::string> head{"voxmap \\ shell"};
  const bool no_shell = who.engine == "implicit";
  for (const int shell : shells) {
    if (!no_shell) head.push_back(cube(shell));
  }
  if (no_shell) head.push_back("no shell");
  table.add(head);
  for (const int voxmap : sizes_of(findings, &Place::voxmap)) {
    std::vector<std::string> cells{cube(voxmap)};
    for (const int shell : shells) {
      if (no_shell && shell != shells.back()) continue;
      const CaseRow* row = findings.find(who, voxmap, shell, "severe");
      cells.push_back(beside(row != nullptr ? fmt::format("{:.2f}", row->ms.median) : "–",
                             paper_ms(who.engine.c_str(), voxmap, shell), "{:.2f}"));
    }
    table.add(cells);
  }
  const char* const source = who.engine == "octree" ? "Table 3" : no_shell ? "Table 5" : "Table 1";
  return table.text(name(who) + ", severe contact, whole frame, ms (the paper's " + source + ")");
}

std::string cases_table(const Findings& findings) {
  TextTable table;
  table.add({"engine", "voxmap", "shell", "case", "contacts", "median ms", "min – max", "kernel ms",
             "published direct / this"});
  for (const CaseRow& row : findings.cases) {
    table.add({name(row.at.who), cube(row.at.voxmap), cube(row.at.shell), row.at.contact,
               row.contacts ? fmt::format("{:.0f}", *row.contacts) : "–", fmt::format("{:.3f}", row.ms.median),
               range(row.ms), fmt::format("{:.3f}", row.kernel_ms),
               row.ratio_to_direct ? fmt::format("{:.2f}", *row.ratio_to_direct) : "–"});
  }
  return table.empty() ? ""
                       : table.text("Every case: a frame alone, broad phase to results read; plunge in batches of 32");
}

std::string phases_table(const Findings& findings) {
  const PaperPhases paper;
  TextTable table;
  table.add({"both at the largest, severe, µs", "OBB–OBB", "VOI", "to device", "kernels", "rest, read-back", "total"});
  table.add({"the paper", fmt::format("{:.2f}", paper.obb), fmt::format("{:.2f}", paper.voi),
             fmt::format("{:.1f}", paper.upload), fmt::format("{:.1f}", paper.kernel),
             fmt::format("{:.1f}", paper.read), fmt::format("{:.1f}", paper.total)});
  if (findings.phases.empty()) return "";
  const Place& last = findings.phases.back().at;
  for (const PhaseRow& row : findings.phases) {
    if (row.at.voxmap != last.voxmap || row.at.shell != last.shell) continue;
    table.add({name(row.at.who), fmt::format("{:.2f}", row.obb), fmt::format("{:.2f}", row.voi),
               fmt::format("{:.1f}", row.upload), fmt::format("{:.1f}", row.kernel), fmt::format("{:.1f}", row.read),
               fmt::format("{:.1f}", row.total)});
  }
  return table.text("Phases (Table 2)");
}

std::optional<double> paper_mb(const double (&table)[5][2], int side, const std::string& engine) {
  const auto row = place(kShells, side);
  if (!row || (engine != "direct" && engine != "octree")) return std::nullopt;
  const double mb = table[*row][engine == "octree" ? 1 : 0];
  return mb < 0 ? std::nullopt : std::optional(mb);
}

std::string memory_table(const Findings& findings) {
  TextTable table;
  table.add({"engine", "voxmap", "MB", "shell", "MB"});
  std::set<std::pair<std::string, int>> shown;
  for (const MemoryRow& row : findings.memory) {
    // The two structures do not depend on each other: each size once.
    const bool new_voxmap = shown.insert({row.engine, row.voxmap}).second;
    const bool new_shell = shown.insert({row.engine, -row.shell}).second;
    if (!new_voxmap && !new_shell) continue;
    table.add({row.engine, new_voxmap ? cube(row.voxmap) : "",
               new_voxmap ? beside(fmt::format("{:.2f}", row.voxmap_mb),
                                   paper_mb(kPaperVoxmapMb, row.voxmap, row.engine), "{:.2f}")
                          : "",
               new_shell ? cube(row.shell) : "",
               new_shell ? beside(fmt::format("{:.2f}", row.shell_mb), paper_mb(kPaperShellMb, row.shell, row.engine),
                                  "{:.2f}")
                         : ""});
  }
  return table.empty() ? "" : table.text("Memory on the device, MB = 10⁶ bytes (Table 4)");
}

std::string voi_table(const Findings& findings) {
  TextTable table;
  table.add({"VOI / tool's box", "engine", "contacts", "with VOI ms", "without ms", "saved"});
  for (const VoiRow& row : findings.voi) {
    table.add({fmt::format("{:.0f} %", 100 * row.fraction), name(row.who), fmt::format("{:.0f}", row.contacts),
               fmt::format("{:.3f}", row.with_ms.median), fmt::format("{:.3f}", row.without_ms.median),
               fmt::format("{:.0f} %", 100 * (1 - row.with_ms.median / row.without_ms.median))});
  }
  return table.empty() ? "" : table.text("VOI (Fig. 8; the paper saves almost 50 % in glenoid reaming)");
}

std::string batches_table(const Findings& findings) {
  TextTable table;
  table.add({"engine", "case", "frames at once", "ms per frame", "min – max"});
  for (const BatchRow& row : findings.batches) {
    table.add({name(row.at.who), row.at.contact, std::to_string(row.batch), fmt::format("{:.3f}", row.ms.median),
               range(row.ms)});
  }
  return table.empty() ? "" : table.text("Frames enqueued together");
}

std::string scatter_table(const Findings& findings) {
  TextTable table;
  table.add(
      {"engine", "voxmap", "points", "in voxels", "counted", "min – max", "contacts ±", "force ±", "component ±"});
  for (const ScatterRow& row : findings.scatter) {
    table.add({name(row.at.who), cube(row.at.voxmap), fmt::format("{:.0f}", row.points),
               row.voxels ? fmt::format("{:.0f}", *row.voxels) : "–", fmt::format("{:.0f}", row.contacts.median),
               fmt::format("{:.0f}", row.contacts.min) + " – " + fmt::format("{:.0f}", row.contacts.max),
               fmt::format("{:.3f} %", 100 * row.contacts_spread), fmt::format("{:.3f} %", 100 * row.force_spread),
               fmt::format("{:.3f} %", 100 * row.component_spread)});
  }
  return table.empty() ? "" : table.text("Effect of races: one severe frame repeated (± standard deviation)");
}

std::string spheres_table(const Findings& findings) {
  TextTable table;
  table.add({"engine", "erosion", "voxel mm", "ms per frame", "min – max", "removed mm³", "volume error"});
  for (const SphereRow& row : findings.spheres) {
    table.add({row.engine, name_of(row.erosion), fmt::format("{:g}", row.voxel_mm),
               fmt::format("{:.4f}", row.ms.median), range(row.ms), fmt::format("{:.1f}", row.removed_mm3),
               fmt::format("{:+.3f} %", 100 * row.volume_error)});
  }
  return table.empty()
             ? ""
             : table.text("A sphere of 29 mm radius plunged 4 mm at 0.2 mm/s and 1 kHz, frames in batches of 32");
}

std::string head(const Findings& findings) {
  std::string out = "reamsim " REAMSIM_VERSION " bench on " + findings.device + " (" + findings.driver + ", " +
                    std::to_string(findings.compute_units) +
                    " compute units); in brackets: the paper's figure on a GTX 970\n" + "medians of " +
                    std::to_string(findings.repetitions) +
                    " repetitions of each of 4 poses, after a warm-up, engines alternating\nshells:";
  for (const auto& [shell, points] : findings.shell_points) {
    out += " " + cube(shell) + " " + std::to_string(points) + " points;";
  }
  out.back() = '\n';
  if (!findings.poses.empty()) out += "points touching at the largest, by pose:";
  for (const PoseCount& pose : findings.poses) {
    out += (pose.pose == 0 ? "  " + pose.contact + " " : ", ") + std::to_string(pose.points);
  }
  return out + "\n\n";
}

std::string skipped_list(const Findings& findings) {
  if (findings.skipped.empty()) return "";
  std::string out = "Not measured\n";
  for (const Skipped& row : findings.skipped) {
    out += "  " + name(row.at.who) + ", voxmap " + cube(row.at.voxmap) + ", shell " + cube(row.at.shell) + ", " +
           row.at.contact + ": " + row.reason + "\n";
  }
  return out + "\n";
}

}  // namespace

std::string text_of(const Findings& findings) {
  std::string out = head(findings);
  for (const Label& who : labels_of(findings)) out += severe_table(findings, who);
  out += phases_table(findings) + memory_table(findings) + voi_table(findings) + batches_table(findings) +
         scatter_table(findings) + spheres_table(findings) + cases_table(findings) + skipped_list(findings);
  return out + fmt::format("took {:.0f} s\n", findings.seconds);
}

}  // namespace reamsim::bench
