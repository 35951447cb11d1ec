// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/plots/plots.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <set>
#include <sstream>

#include "sim/anatomy/column_map.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/process.h"
#include "sim/base/text.h"

namespace reamsim {
namespace {

/// Mean cutting power in W over the last `step` rows, or over the frames of the row's means if those are more.
double mean_power_w(const ForceLog& log, std::size_t i, std::size_t step) {
  const ForceRow &first = log.rows[i - std::min(i, step)], &last = log.rows[i];
  RowPoint begin{.time_s = first.time_s, .cumulative_energy_mj = first.cumulative_energy_mj};
  if (last.layer_begin.time_s < begin.time_s) begin = last.layer_begin;
  const double time_s = last.time_s - begin.time_s;
  return time_s > 0 ? (last.cumulative_energy_mj - begin.cumulative_energy_mj) / time_s / 1000 : 0;
}

/// A gnuplot data block with the means over a voxel of travel, decimated.
std::string mean_block(const ForceLog& log) {
  constexpr std::size_t kMaxPoints = 2000;
  const std::size_t step = 1 + log.rows.size() / kMaxPoints;
  const double travel_mm = log.mean_travel_mm;
  const KeyResults run = key_results_of(log);
  const auto text = [](const KeyResults::Figure& figure) { return gnuplot_string(figure.name + " " + figure.value()); };
  std::ostringstream out;
  out << "# Headline figures, as in pictures, summary.json and report\n"
      << "headline_force = " << text(run.force()) << "\nheadline_torque = " << text(run.torque())
      << "\nheadline_depth = " << text(run.depth()) << "\n\n"
      << "# Means over the last " << travel_mm
      << " mm of travel (0: single frames): time (s), axial force (N), spin torque (N·mm), depth (mm), cutting power "
         "(W)\n"
      << "travel_mm = " << travel_mm << "\n$mean << END\n";
  for (std::size_t i = 0; i < log.rows.size(); i += step) {
    const ForceRow& row = log.rows[i];
    // A mean is plotted in the middle of its frames.
    const RowPoint& middle = row.layer_middle;
    out << middle.time_s << ',' << row.layer_axial_force_n << ',' << row.layer_spin_torque_nmm << ',' << middle.depth_mm
        << ',' << mean_power_w(log, i, step) << '\n';
  }
  out << "END\n\n";
  return out.str();
}

/// A pass from the row before it removes bone to the last one in which it does.
struct CuttingPass {
  const ForceRow* first = nullptr;
  const ForceRow* last = nullptr;
  double peak_force_n = 0;
  double peak_torque_nmm = 0;
};

std::vector<CuttingPass> cutting_passes(const ForceLog& log) {
  std::vector<CuttingPass> out;
  for (std::size_t i = 1; i < log.rows.size(); ++i) {
    const ForceRow& row = log.rows[i];
    if (row.removed_mm3 <= log.rows[i - 1].removed_mm3) continue;
    if (out.empty() || out.back().last->pass != row.pass) out.push_back({.first = &log.rows[i - 1]});
    CuttingPass& pass = out.back();
    pass.last = &row;
    pass.peak_force_n = std::max(pass.peak_force_n, row.layer_axial_force_n);
    pass.peak_torque_nmm = std::max(pass.peak_torque_nmm, std::abs(row.layer_spin_torque_nmm));
  }
  return out;
}

/// What the scripts know of several passes: the time before each that they hide, and where to put its number.
std::string pass_block(const ForceLog& log) {
  constexpr double kMargin = 0.05;  // of the time of contact, shown before and after that of a pass
  std::vector<CuttingPass> passes = cutting_passes(log);
  if (passes.size() < 2) return "passes = 0\n$pass_end << END\n0,0,0,0,0\nEND\n\n";
  double contact_s = 0;
  for (const CuttingPass& pass : passes) contact_s += pass.last->time_s - pass.first->time_s;
  std::ostringstream out;
  out << "# Passes that remove bone: their numbers, and the time before each that is not shown, from and to (s)\n"
      << "passes = " << passes.size() << '\n'
      << "array pass_number[passes]\narray hidden_from[passes]\narray hidden_to[passes]\n";
  for (std::size_t i = 0; i < passes.size(); ++i) {
    const double to = passes[i].first->time_s - kMargin * contact_s;
    const double from = i == 0 ? to : std::min(to, passes[i - 1].last->time_s + kMargin * contact_s);
    const std::string index = "[" + std::to_string(i + 1) + "] = ";
    out << "pass_number" << index << passes[i].last->pass << "; hidden_from" << index << from << "; hidden_to" << index
        << to << '\n';
  }
  out << "# Of each: greatest depth (mm), axial force (N) and spin torque (N·mm), removed volume at its end (mm³), "
         "number\n"
      << "$pass_end << END\n";
  for (const CuttingPass& pass : passes) {
    out << pass.last->depth_mm << ',' << pass.peak_force_n << ',' << pass.peak_torque_nmm << ','
        << pass.last->removed_mm3 << ',' << pass.last->pass << '\n';
  }
  out << "END\n\n";
  return out.str();
}

constexpr const char* kDecimated = "forces_decimated.csv";

/// Writes what the scripts read of a decimated log. What forces.csv has per frame is the sum since the row before.
void write_decimated(const std::string& dir, const ForceLog& log) {
  CsvWriter csv = plot_csv(dir, kDecimated,
                           "frame,time_s,depth_mm,axial_force_n,spin_torque_nmm,removed_mm3,energy_mj,floor_energy_mj,"
                           "balance");
  ForceRow before;
  for (const ForceRow& row : log.rows) {
    csv.row({static_cast<double>(row.frame), row.time_s, row.depth_mm, row.axial_force_n, row.spin_torque_nmm,
             row.removed_mm3 - before.removed_mm3, row.cumulative_energy_mj - before.cumulative_energy_mj,
             row.cumulative_floor_mj - before.cumulative_floor_mj, row.balance});
    before = row;
  }
  csv.close();
}

/// The data of all plots against time and depth.
std::string data_of(const std::string& dir, const ForceLog& log) {
  if (!log.is_decimated()) return pass_block(log) + mean_block(log);
  write_decimated(dir, log);
  std::ostringstream out;
  out << "# Of every " << log.bucket_rows << " rows of forces.csv the first and the extremes\n"
      << "csv = \"plots/" << kDecimated << "\"\nbucket_rows = " << log.bucket_rows << "\n\n"
      << pass_block(log) << mean_block(log);
  return out.str();
}

// All classes have the same number of grades.
constexpr int kGradesPerClass = 5;
constexpr std::size_t kClasses = 250 / kGradesPerClass;

/// Data of the script of a benchmark: programs by their number.
std::string data_of(const BenchPlot& plot) {
  // Okabe and Ito's colours, safe for colour-blind readers.
  constexpr std::array kColors{"#009e73", "#0072b2", "#56b4e9", "#d55e00", "#e69f00", "#8c4f86", "#404040"};
  std::vector<std::string> programs;
  const auto number = [&](const std::string& program) {
    return std::ranges::find(programs, program) - programs.begin();
  };
  std::set<int> voxmaps;
  std::ostringstream out;
  out << "# program, voxmap, shell, ms, the paper's ms\n$severe << END\n";
  for (const auto& point : plot.severe) {
    if (number(point.program) == std::ssize(programs)) programs.push_back(point.program);
    voxmaps.insert(point.voxmap);
    out << number(point.program) + 1 << ' ' << point.voxmap << ' ' << point.shell << ' ' << point.ms << ' '
        << (point.paper_ms ? (std::ostringstream() << *point.paper_ms).str() : "NaN") << '\n';
  }
  out << "END\n# program, VOI in % of the tool's box, ms with VOI, ms without\n$voi << END\n";
  for (const auto& point : plot.voi) {
    out << number(point.program) + 1 << ' ' << point.percent << ' ' << point.with_ms << ' ' << point.without_ms << '\n';
  }
  if (plot.voi.empty()) out << "0 0 NaN NaN\n";
  const std::size_t arrays = std::max<std::size_t>(1, programs.size());
  out << "END\nprograms = " << programs.size() << "\narray name[" << arrays << "]\narray color[" << arrays << "]\n";
  for (std::size_t i = 0; i < programs.size(); ++i) {
    out << "name[" << i + 1 << "] = " << gnuplot_string(programs[i]) << "\ncolor[" << i + 1 << "] = \""
        << kColors.at(i % kColors.size()) << "\"\n";
  }
  out << "voxmaps = \"";
  for (const int voxmap : voxmaps) out << voxmap << ' ';
  out << "\"\nhas_voi = " << (plot.voi.empty() ? 0 : 1) << "\ndevice = " << gnuplot_string(plot.device) << "\n\n";
  return out.str();
}

std::string on_one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  const std::string_view words = without_blanks(text, " ");
  return words.empty() ? "no message" : std::string(words);
}

}  // namespace

CsvWriter plot_csv(const std::string& dir, const std::string& name, const std::string& header) {
  std::error_code error;
  std::filesystem::create_directories(dir + "/plots", error);
  return {dir + "/plots/" + name, header};
}

void draw_plot(const std::string& dir, const std::string& name, const std::string& data, const char* script) {
  const std::string head = "# Makes " + name +
                           ".png, .svg and .pdf. Edit it, and run it again in the results folder:\n# gnuplot " + name +
                           ".gp\n\n";
  std::error_code error;
  std::filesystem::create_directories(std::filesystem::path(dir + "/" + name).parent_path(), error);
  run_gnuplot(dir, name + ".gp", head + data + embedded::script_style + script,
              {name + ".png", name + ".svg", name + ".pdf"});
}

void write_force_plots(const std::string& dir, const ForceLog& log) {
  draw_plot(dir, "forces", data_of(dir, log), embedded::script_forces);
}

void write_depth_and_energy_plots(const std::string& dir, const ForceLog& log) {
  const std::string data = data_of(dir, log);
  draw_plot(dir, "plots/forces_depth", data, embedded::script_forces_depth);
  draw_plot(dir, "plots/energy", data, embedded::script_energy);
}

void write_feedback_plots(const std::string& dir, PoseFeedback feedback) {
  const std::string data = "csv = \"forces.csv\"\n\n";
  if (feedback.push) draw_plot(dir, "plots/push", data, embedded::script_push);
  if (feedback.springs) draw_plot(dir, "plots/deflection", data, embedded::script_deflection);
}

void write_removed_density(const std::string& dir, const BoneView& bone) {
  std::array<double, kClasses> removed_mm3{};
  for_each_cut_voxel(bone, [&](const Vec3i&, int grade, int before, int after) {
    const std::size_t density_class = std::min<std::size_t>((grade - 1) / kGradesPerClass, kClasses - 1);
    removed_mm3[density_class] +=
        static_cast<double>(before - after) / FillBricks::kWhole * bone.voxmap.grid.voxel_mm3();
  });
  CsvWriter csv = plot_csv(dir, "removed_density.csv", "density_from_g_cm3,density_to_g_cm3,removed_mm3");
  for (std::size_t i = 0; i < kClasses; ++i) {
    // In thousandths, so that the bounds are round numbers.
    const auto bound = [](std::size_t place) { return static_cast<double>(place * kGradesPerClass * 8) / 1000; };
    csv.row({bound(i), bound(i + 1), removed_mm3[i]});
  }
  csv.close();
  draw_plot(dir, "plots/removed_density", "", embedded::script_removed_density);
}

void write_bench_plot(const std::string& dir, const BenchPlot& plot) {
  run_gnuplot(dir, "bench.gp", data_of(plot) + embedded::script_bench, {"bench.png", "bench.svg"});
}

std::string gnuplot_string(const std::string& text) {
  return "'" + replace_all(printable(text), {{"'", "''"}}) + "'";
}

void run_gnuplot(const std::string& dir, const std::string& script, const std::string& text,
                 const std::vector<std::string>& pictures) {
  write_file(dir + "/" + script, text);
  const MemoryFile messages("the messages of gnuplot");
  pid_t child = 0;
  // -d: without the user's own settings, which could change the figures.
  const int error_number =
      spawn({.arguments = {"gnuplot", "-d", script}, .dir = dir, .err = messages.descriptor()}, child);
  if (error_number != 0) throw RunError(std::string("gnuplot cannot be started: ") + std::strerror(error_number));
  if (!succeeded(wait_for(child))) {
    throw RunError(dir + ": gnuplot failed on " + script + ": " + on_one_line(messages.contents()));
  }
  for (const std::string& name : pictures) {
    std::error_code error;
    if (std::filesystem::file_size(dir + "/" + name, error) == 0 || error) {
      throw RunError(dir + "/" + name + ": gnuplot wrote nothing: " + on_one_line(messages.contents()));
    }
  }
}

}  // namespace reamsim
