// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/base/csv.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/record/force_log.h"
#include "sim/record/verification.h"

namespace reamsim {

/// The gnuplot scripts, by their files.
namespace embedded {
using Script = const char* const;
extern Script script_style, script_forces, script_forces_depth, script_energy, script_push, script_deflection,
    script_removed_density, script_spectrum, script_compare, script_bench, script_verify;
}  // namespace embedded

// The functions below throw RunError when gnuplot is missing or fails, or a file cannot be written.

/// Draws DIR/forces.csv against time as DIR/forces .png, .svg, .pdf and the script .gp. `log`: that file, read with the
/// travel of its means (0: single frames only); a decimated one is written to DIR/plots/forces_decimated.csv and drawn.
void write_force_plots(const std::string& dir, const ForceLog& log);

/// Draws DIR/plots/forces_depth and DIR/plots/energy. Arguments as for write_force_plots().
void write_depth_and_energy_plots(const std::string& dir, const ForceLog& log);

/// Draws DIR/plots/push and deflection, from the columns of forces.csv that a push or a tool on springs adds.
void write_feedback_plots(const std::string& dir, PoseFeedback feedback);

/// Writes the removed volume per density class as DIR/plots/removed_density.csv and draws it.
void write_removed_density(const std::string& dir, const BoneView& bone);

/// What the spectrum needs of a row of forces.csv.
struct TorqueSample {
  double time_s = 0;
  double angle_rad = 0;   ///< of the spin
  double torque_nmm = 0;  ///< about the spin axis
};

/// One-sided amplitude spectrum of the spin torque in contact.
struct TorqueSpectrum {
  struct Line {
    double frequency_hz = 0;
    double torque_nmm = 0;  ///< amplitude
  };
  std::vector<Line> lines;
  std::vector<Line> peaks;  ///< the highest at multiples of the spin, ascending in frequency
  double spin_hz = 0;       ///< revolutions per second in contact
};

/// The spectrum of the longest stretch of frames with torque by Welch's method (1967, doi:10.1109/TAU.1967.1161901):
/// Hann windows that overlap by half, zero-padded, less the mean over a revolution, which has the feed's trend and no
/// multiple of the spin. Empty without spin, for less than three revolutions, or for one of more than 100,000 frames.
TorqueSpectrum torque_spectrum(const std::vector<TorqueSample>& samples);

/// Writes the spectrum as DIR/plots/spectrum.csv and draws it with labelled peaks. Returns false if it is empty.
bool write_torque_spectrum(const std::string& dir);

/// Runs DIR/`name`.gp (a head comment, `data`, the common style, `script`), which makes DIR/`name` .png, .svg and .pdf.
void draw_plot(const std::string& dir, const std::string& name, const std::string& data, const char* script);

/// Opens DIR/plots/`name` and creates the folder if it is missing. Throws RunError.
CsvWriter plot_csv(const std::string& dir, const std::string& name, const std::string& header);

/// `text` as a single-quoted gnuplot string: in double quotes gnuplot would run text between backticks as a command.
std::string gnuplot_string(const std::string& text);

/// Writes `text` to `script` in the folder `dir` and runs gnuplot on it there; `pictures` must exist afterwards.
void run_gnuplot(const std::string& dir, const std::string& script, const std::string& text,
                 const std::vector<std::string>& pictures);

/// Data of a benchmark's figure: times of severe contact by voxmap and shell, and against the VOI.
struct BenchPlot {
  struct Point {
    std::string program;
    int voxmap = 0;  ///< cells along an edge
    int shell = 0;
    double ms = 0;
    std::optional<double> paper_ms;
  };
  struct VoiPoint {
    std::string program;
    double percent = 0;  ///< of the tool's box
    double with_ms = 0;
    double without_ms = 0;
  };

  std::string device;
  std::vector<Point> severe;
  std::vector<VoiPoint> voi;
};

/// Writes bench.gp, bench.png and bench.svg into `dir`.
void write_bench_plot(const std::string& dir, const BenchPlot& plot);

/// The report of a verification: tables in Markdown, with a reference to verification.png.
std::string verification_markdown(const verify::Findings& findings);
/// One page on the device: capabilities, agreement of the engines, speed.
std::string device_markdown(const verify::Findings& findings);
/// The report as JSON; see docs/columns.md.
std::string verification_json(const verify::Findings& findings);

/// Writes device.md, verification.md, verification.json, and the figure of the refinements (verification.gp, .png,
/// .svg).
void write_verification(const std::string& dir, const verify::Findings& findings);

struct ComparedRun {
  std::string dir;            ///< results folder
  std::string label;          ///< in legends and tables
  double mean_travel_mm = 0;  ///< tool travel over which forces are averaged; 0: single frames
};

/// A number of summary.json in all runs; NaN where missing.
struct ComparedMetric {
  std::string key;  ///< "forces.peak_force_n"
  std::vector<double> values;

  /// Run `i` minus the first one.
  [[nodiscard]] double difference(std::size_t i) const { return values[i] - values[0]; }
  /// As a fraction of the first one; NaN where that is 0.
  [[nodiscard]] double relative(std::size_t i) const;
};

/// A key of the scenario whose value differs between the runs.
struct ComparedParameter {
  std::string key;                  ///< "motion.plunge.depth_mm"
  std::vector<std::string> values;  ///< as in scenario.yaml, lists on one line; "" where a run lacks the key
  std::vector<double> numbers;      ///< the same as numbers; NaN where the value is none
  std::vector<std::string> shown;   ///< of paths the file name, where no two paths share one; else as `values`

  [[nodiscard]] std::size_t distinct() const;
};

struct Comparison {
  std::vector<ComparedRun> runs;
  std::vector<ComparedParameter> parameters;
  std::vector<ComparedMetric> metrics;
  std::string color_by;  ///< key of a parameter or metric that colours the curves; "": chosen by colored_by()
};

/// All numbers of the runs' summary.json in file order, those of the first run first. Throws InputError.
std::vector<ComparedMetric> compare_summaries(const std::vector<ComparedRun>& runs);

/// The keys of the runs' scenario.yaml that differ and change numbers, in file order. An input file that changed under
/// one path is a parameter "KEY (contents)", the beginning of its SHA-256. Throws InputError: missing or damaged.
std::vector<ComparedParameter> compare_scenarios(const std::vector<ComparedRun>& runs);

/// What colours the curves: `color_by`; else, with more runs than line styles, the parameter that correlates most with
/// the peak axial force by rank, or the number of the run (key ""). Throws InputError when `color_by` is no number.
std::optional<ComparedMetric> colored_by(const Comparison& comparison);

/// The number of line styles that can be told apart.
constexpr std::size_t kLineStyles = 20;

/// Writes to DIR: compare.csv (a row for each metric and run), runs.csv (a row for each run: parameters, then metrics),
/// curves.csv, and compare.png, .svg, .pdf and .gp: force, torque and removed volume of every run against time and
/// depth since first contact. Throws InputError (a damaged forces.csv, or as colored_by()), RunError (gnuplot, disk).
void write_comparison(const std::string& dir, const Comparison& comparison);

/// The characters of a UTF-8 text.
std::vector<std::string> characters_of(const std::string& text);

struct RunColumn {
  std::string key;                 ///< "motion.plunge.depth_mm"
  std::vector<std::string> cells;  ///< one per run
};

/// The lines of a table of runs, none wider than `width` characters. A row per column where that fits; otherwise a row
/// per run, wrapped into blocks of columns. Keys are shortened to their last parts, as many as tell them apart. What is
/// longer still is replaced by a number or letter, and listed below the table. Texts must be printable.
std::vector<std::string> run_table(const std::vector<std::string>& labels, const std::vector<RunColumn>& columns,
                                   std::size_t width);

}  // namespace reamsim
