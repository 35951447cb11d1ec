#pragma once

#include <string>
#include <vector>

#include "sim/base/csv.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// Over how much of the tool's travel forces are averaged before they are shown, mm: a voxel, because voxels that go
/// whole make spikes of single frames; nothing where they are clipped, because a mean would only smear contact's ends.
double averaged_travel_mm(const CuttingSettings& cutting, double voxel_mm);

/// Draws DIR/forces.csv with gnuplot: DIR/forces (against time), DIR/plots/forces_depth and DIR/plots/energy, each as
/// .png, .svg, .pdf and the script .gp. `mean_travel_mm` is the travel over which the means are taken that stand before
/// the single frames; 0: the frames alone.
/// Throws InputError when forces.csv is missing or damaged, RunError when gnuplot is missing or fails (with its words).
void write_force_plots(const std::string& dir, double mean_travel_mm);

/// Draws DIR/plots/forces_depth and DIR/plots/energy from DIR/forces.csv. `mean_travel_mm` as in write_force_plots(),
/// which see for what is thrown.
void write_depth_and_energy_plots(const std::string& dir, double mean_travel_mm);

/// Writes what a run removed of each class of density as DIR/plots/removed_density.csv, and draws it. `before`,
/// `after`: the fill. Throws RunError when gnuplot fails.
void write_removed_density(const std::string& dir, const Voxmap& voxmap, const FillBricks& before,
                           const FillBricks& after);

/// Writes the spectrum of the spin torque as DIR/plots/spectrum.csv, and draws it with its peaks named. False, and
/// nothing written, when the tool does not spin or cuts for less than four turns. Throws as above.
bool write_torque_spectrum(const std::string& dir);

/// Writes the script DIR/`name`.gp, which begins with a line that says what it makes and how to run it again, goes on
/// with `data` (gnuplot's own) and the look that all plots share, and ends with `script`; runs it in DIR. Throws
/// RunError when one of DIR/`name`.png, .svg and .pdf is not there afterwards.
void draw_plot(const std::string& dir, const std::string& name, const std::string& data, const char* script);

/// Opens DIR/plots/`name` and creates the folder if it is missing. Throws RunError.
CsvWriter plot_csv(const std::string& dir, const std::string& name, const std::string& header);

/// `text` as a string of gnuplot: in single quotes, within which gnuplot expands nothing. Double quotes would run what
/// stands between backticks as a command. Control characters become spaces.
std::string gnuplot_string(const std::string& text);

/// Writes `text` to `script` in the folder `dir` and runs gnuplot on it there. Throws RunError when the script cannot
/// be written, gnuplot is missing or complains, or one of `pictures` (names in `dir`) is not there afterwards.
void run_gnuplot(const std::string& dir, const std::string& script, const std::string& text,
                 const std::vector<std::string>& pictures);

}  // namespace reamsim
