// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/plots/plots.h"

#include <fmt/core.h>
#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <span>
#include <unsupported/Eigen/FFT>

#include "sim/base/text.h"

namespace reamsim {
namespace {

constexpr std::size_t kMinTurns = 3;     // in contact
constexpr std::size_t kWindowTurns = 8;  // per window, at most
constexpr std::size_t kMaxPeaks = 4;
constexpr double kMinPeak = 0.25;  // fraction of the highest

/// More frames per revolution would need too much memory.
constexpr double kMaxFramesPerTurn = 100'000;

/// The longest stretch of rows with torque, without a gap of a whole revolution.
std::span<const TorqueSample> longest_contact(std::span<const TorqueSample> samples) {
  std::span<const TorqueSample> longest, now;
  for (std::size_t i = 0, first = 0; i < samples.size(); ++i) {
    if (samples[i].torque_nmm == 0) continue;
    if (now.empty() || std::abs(samples[i].angle_rad - now.back().angle_rad) >= 2 * std::numbers::pi) first = i;
    now = samples.subspan(first, i - first + 1);
    if (now.size() > longest.size()) longest = now;
  }
  return longest;
}

/// The torque of the contact minus its centred mean over `turn` frames, half a `turn` from each end.
std::vector<double> without_mean(std::span<const TorqueSample> contact, std::size_t turn) {
  std::vector<double> out;
  double sum = 0;
  for (std::size_t i = 0; i < contact.size(); ++i) {
    sum += contact[i].torque_nmm;
    if (i + 1 < turn) continue;
    out.push_back(contact[i - turn / 2].torque_nmm - sum / static_cast<double>(turn));
    sum -= contact[i + 1 - turn].torque_nmm;
  }
  return out;
}

/// Adds the power of a window of values to that of the lines of its spectrum.
void add_window(std::span<const double> values, std::size_t length, std::vector<double>& power) {
  std::vector<double> windowed(length, 0.0);
  double weights = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double hann = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * (static_cast<double>(i) + 0.5) /
                                             static_cast<double>(values.size()));
    windowed[i] = hann * values[i];
    weights += hann;
  }
  Eigen::FFT<double> transform;
  std::vector<std::complex<double>> lines;
  transform.fwd(lines, windowed);
  for (std::size_t i = 0; i < power.size(); ++i) power[i] += std::norm(2.0 / weights * lines[i]);
}

/// Welch's method: the mean over windows that overlap by half.
std::vector<TorqueSpectrum::Line> welch(std::span<const double> values, std::size_t window, double rate_hz) {
  const std::size_t length = std::bit_ceil(4 * window);
  std::vector<double> power(length / 2 + 1, 0.0);
  std::size_t windows = 0;
  for (std::size_t at = 0; at + window <= values.size(); at += window / 2, ++windows) {
    add_window(values.subspan(at, window), length, power);
  }
  std::vector<TorqueSpectrum::Line> out;
  for (std::size_t i = 0; i < power.size(); ++i) {
    out.push_back({static_cast<double>(i) * rate_hz / static_cast<double>(length),
                   std::sqrt(power[i] / static_cast<double>(windows))});
  }
  return out;
}

/// The highest lines at multiples of the spin, where cutting edges have theirs; others are artefacts of the voxels.
std::vector<TorqueSpectrum::Line> find_peaks(const std::vector<TorqueSpectrum::Line>& lines, double spin_hz) {
  using Line = TorqueSpectrum::Line;
  std::vector<Line> out;
  for (std::size_t i = 1; i + 1 < lines.size(); ++i) {
    const bool top = lines[i].torque_nmm > lines[i - 1].torque_nmm && lines[i].torque_nmm >= lines[i + 1].torque_nmm;
    const double order = lines[i].frequency_hz / spin_hz;
    if (top && order > 0.5 && std::abs(order - std::round(order)) < 0.1) out.push_back(lines[i]);
  }
  std::sort(out.begin(), out.end(), [](const Line& a, const Line& b) { return a.torque_nmm > b.torque_nmm; });
  if (out.size() > kMaxPeaks) out.resize(kMaxPeaks);
  const double least_nmm = out.empty() ? 0 : kMinPeak * out.front().torque_nmm;
  std::erase_if(out, [&](const Line& line) { return line.torque_nmm < least_nmm; });
  std::ranges::sort(out, {}, &Line::frequency_hz);
  return out;
}

/// The peaks and the end of the axis for the script.
std::string peaks_block(const TorqueSpectrum& spectrum) {
  double last_hz = 10 * spectrum.spin_hz;
  std::string out = "# The highest peaks: frequency (Hz), amplitude (N·mm), label\n$peaks << END\n";
  for (const auto& [frequency_hz, torque_nmm] : spectrum.peaks) {
    out += shortest_text(frequency_hz) + "," + shortest_text(torque_nmm) +
           fmt::format(",\"{:.3g} Hz\\n{:.0f} × spin\"\n", frequency_hz, std::round(frequency_hz / spectrum.spin_hz));
    last_hz = std::max(last_hz, frequency_hz);
  }
  if (spectrum.peaks.empty()) out += "-1,0,\"\"\n";
  return out + "END\n# Where the axis ends; plots/spectrum.csv goes on to half the frame rate.\nshown_hz = " +
         shortest_text(2 * last_hz) + "\n\n";
}

}  // namespace

TorqueSpectrum torque_spectrum(const std::vector<TorqueSample>& samples) {
  TorqueSpectrum out;
  const std::span<const TorqueSample> contact = longest_contact(samples);
  if (contact.size() < 2) return out;
  const TorqueSample &first = contact.front(), &last = contact.back();
  const double duration_s = last.time_s - first.time_s;
  const double rate_hz = static_cast<double>(contact.size() - 1) / duration_s;
  const double spin_hz = std::abs(last.angle_rad - first.angle_rad) / (2 * std::numbers::pi) / duration_s;
  const double frames_per_turn = spin_hz > 0 ? rate_hz / spin_hz : 0;
  if (!(frames_per_turn >= 2) || frames_per_turn > kMaxFramesPerTurn) return out;
  if (static_cast<double>(contact.size()) < (kMinTurns + 1) * frames_per_turn) return out;
  const auto turn = static_cast<std::size_t>(std::lround(frames_per_turn));
  const std::vector<double> torque_nmm = without_mean(contact, turn);
  out.spin_hz = spin_hz;
  out.lines = welch(torque_nmm, std::min(torque_nmm.size(), kWindowTurns * turn), rate_hz);
  out.peaks = find_peaks(out.lines, spin_hz);
  return out;
}

bool write_torque_spectrum(const std::string& dir) {
  std::vector<TorqueSample> samples;
  for_each_force_row(dir + "/forces.csv", [&](const ForceRow& row) {
    samples.push_back({row.time_s, row.pose.spin_angle_rad, row.spin_torque_nmm});
  });
  const TorqueSpectrum spectrum = torque_spectrum(samples);
  if (spectrum.lines.empty()) return false;
  CsvWriter csv = plot_csv(dir, "spectrum.csv", "frequency_hz,frequency_per_spin,spin_torque_nmm");
  for (const auto& [frequency_hz, torque_nmm] : spectrum.lines) {
    csv.row({frequency_hz, frequency_hz / spectrum.spin_hz, torque_nmm});
  }
  csv.close();
  draw_plot(dir, "plots/spectrum", peaks_block(spectrum), embedded::script_spectrum);
  return true;
}

}  // namespace reamsim
