// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
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
extern const char* const script_style;
extern const char* const script_forces;
extern const char* const script_forces_depth;
extern const char* const script_energy;
extern const char* const script_push;
extern const char* const script_deflection;
extern const char* const script_removed_density;
extern const char* const script_spectrum;
extern const char* const script_compare;
extern const char* const script_bench;
extern const char* const script_verify;
}  // namespace embedded

// The functions below throw RunError when gnuplot is missing or fails, or a file cannot be written.

/// Draws DIR/forces.csv against time with gnuplot as DIR/forces .png, .svg, .pdf and the script .gp. `log`: that file,
/// read with the travel over which the means shown with single frames are taken (0: single frames only). A decimated
/// log is written to DIR/plots/forces_decimated.csv and drawn from there.
void write_force_plots(const std::string& dir, const ForceLog& log);

/// Draws DIR/plots/forces_depth and DIR/plots/energy. Arguments as for write_force_plots().
void write_depth_and_energy_plots(const std::string& dir, const ForceLog& log);

/// Draws DIR/plots/push or deflection, from the columns of forces.csv that a push or a tool on springs adds.
void write_push_plot(const std::string& dir);
void write_deflection_plot(const std::string& dir);

/// Writes the removed volume per density class as DIR/plots/removed_density.csv and draws it. `before`, `after`: fill.
void write_removed_density(const std::string& dir, const Voxmap& voxmap, const FillBricks& before,
                           const FillBricks& after);

/// Calls a function with each row of a log, in order.
using RowPass = std::function<void(const std::function<void(const ForceRow&)>&)>;

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
/// Hann windows that overlap by half, zero-padded. The mean over one revolution is subtracted, which removes the feed's
/// trend and no multiple of the spin. Empty without spin, or when fewer than three revolutions remain, or for a
/// revolution of more than 100,000 frames.
TorqueSpectrum torque_spectrum(const RowPass& pass);

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
/// The report as JSON; see docs/columns.md.
std::string verification_json(const verify::Findings& findings);

/// Writes verification.md, verification.json, and the figure of the refinements (verification.gp, .png, .svg).
void write_verification(const std::string& dir, const verify::Findings& findings);

}  // namespace reamsim
