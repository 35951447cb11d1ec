#include "render/plots/plots.h"

#include <fmt/core.h>
#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>
#include <unsupported/Eigen/FFT>

#include "sim/base/text.h"

namespace reamsim {
namespace embedded {
extern const char* const spectrum_script;
}
namespace {

constexpr std::size_t kMinTurns = 3;     // in contact
constexpr std::size_t kWindowTurns = 8;  // per window, at most
constexpr std::size_t kMaxPeaks = 4;
constexpr double kMinPeak = 0.25;  // fraction of the highest

/// First row and number of rows of the longest stretch with torque, without a gap of a whole revolution.
std::pair<std::size_t, std::size_t> longest_contact(const ForceLog& log) {
  std::size_t first = 0, count = 0, begin = 0;
  std::optional<std::size_t> last;
  for (std::size_t i = 0; i < log.rows.size(); ++i) {
    if (log.rows[i].spin_torque_nmm == 0) continue;
    const bool near =
        last && std::abs(log.rows[i].pose.spin_angle_rad - log.rows[*last].pose.spin_angle_rad) < 2 * std::numbers::pi;
    if (!near) begin = i;
    last = i;
    if (i - begin + 1 > count) {
      first = begin;
      count = i - begin + 1;
    }
  }
  return {first, count};
}

/// The torque minus its centred mean over `turn` frames; half a revolution at each end is dropped.
std::vector<double> without_mean(const ForceLog& log, std::size_t first, std::size_t count, std::size_t turn) {
  std::vector<double> out;
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    sum += log.rows[first + i].spin_torque_nmm;
    if (i + 1 < turn) continue;
    const std::size_t middle = i - turn / 2;
    out.push_back(log.rows[first + middle].spin_torque_nmm - sum / static_cast<double>(turn));
    sum -= log.rows[first + i + 1 - turn].spin_torque_nmm;
  }
  return out;
}

/// Adds the power of one window of `values` to `power`.
void add_window(const double* values, std::size_t length, std::vector<double>& power) {
  std::vector<double> windowed(2 * (power.size() - 1), 0.0);
  double weights = 0;
  for (std::size_t i = 0; i < length; ++i) {
    const double hann =
        0.5 - 0.5 * std::cos(2 * std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(length));
    windowed[i] = hann * values[i];
    weights += hann;
  }
  Eigen::FFT<double> transform;
  std::vector<std::complex<double>> lines;
  transform.fwd(lines, windowed);
  for (std::size_t i = 0; i < power.size(); ++i) power[i] += std::norm(2.0 / weights * lines[i]);
}

std::vector<TorqueSpectrum::Line> welch(const std::vector<double>& values, std::size_t window, double rate_hz) {
  const std::size_t length = std::bit_ceil(4 * window);
  std::vector<double> power(length / 2 + 1, 0.0);
  std::size_t windows = 0;
  for (std::size_t begin = 0; begin + window <= values.size(); begin += window / 2, ++windows) {
    add_window(values.data() + begin, window, power);
  }
  std::vector<TorqueSpectrum::Line> out;
  for (std::size_t i = 0; i < power.size(); ++i) {
    out.push_back({static_cast<double>(i) * rate_hz / static_cast<double>(length),
                   std::sqrt(power[i] / static_cast<double>(windows))});
  }
  return out;
}

/// Cutting edges are periodic with the spin, so their lines are at its multiples. Other lines are artefacts of the
/// voxels.
bool multiple_of_spin(double frequency_hz, double spin_hz) {
  const double order = frequency_hz / spin_hz;
  return order > 0.5 && std::abs(order - std::round(order)) < 0.1;
}

/// The highest lines at multiples of the spin, ascending in frequency.
std::vector<TorqueSpectrum::Line> find_peaks(const std::vector<TorqueSpectrum::Line>& lines, double spin_hz) {
  using Line = TorqueSpectrum::Line;
  std::vector<Line> out;
  for (std::size_t i = 1; i + 1 < lines.size(); ++i) {
    const bool top = lines[i].torque_nmm > lines[i - 1].torque_nmm && lines[i].torque_nmm >= lines[i + 1].torque_nmm;
    if (top && multiple_of_spin(lines[i].frequency_hz, spin_hz)) out.push_back(lines[i]);
  }
  std::sort(out.begin(), out.end(), [](const Line& a, const Line& b) { return a.torque_nmm > b.torque_nmm; });
  if (out.size() > kMaxPeaks) out.resize(kMaxPeaks);
  const double least_nmm = out.empty() ? 0 : kMinPeak * out.front().torque_nmm;
  std::erase_if(out, [&](const Line& line) { return line.torque_nmm < least_nmm; });
  std::ranges::sort(out, {}, &Line::frequency_hz);
  return out;
}

/// "25.0 Hz" and, on a line below, "6 × spin".
std::string peak_label(double frequency_hz, double spin_hz) {
  return fmt::format("{:.3g} Hz\\n{:.0f} × spin", frequency_hz, std::round(frequency_hz / spin_hz));
}

/// The peaks and the end of the axis for the script.
std::string peaks_block(const TorqueSpectrum& spectrum) {
  double last_hz = 10 * spectrum.spin_hz;
  std::string out = "# The highest peaks: frequency (Hz), amplitude (N·mm), label\n$peaks << END\n";
  for (const auto& [frequency_hz, torque_nmm] : spectrum.peaks) {
    out += shortest_text(frequency_hz) + "," + shortest_text(torque_nmm) + ",\"" +
           peak_label(frequency_hz, spectrum.spin_hz) + "\"\n";
    last_hz = std::max(last_hz, frequency_hz);
  }
  if (spectrum.peaks.empty()) out += "-1,0,\"\"\n";
  return out + "END\n# Where the axis ends; plots/spectrum.csv goes on to half the frame rate.\nshown_hz = " +
         shortest_text(2 * last_hz) + "\n\n";
}

}  // namespace

TorqueSpectrum torque_spectrum(const ForceLog& log) {
  TorqueSpectrum out;
  const auto [first, count] = longest_contact(log);
  if (count < 2) return out;
  const ForceRow& begin = log.rows[first];
  const ForceRow& end = log.rows[first + count - 1];
  const double rate_hz = static_cast<double>(count - 1) / (end.time_s - begin.time_s);
  const double spin_hz = std::abs(end.pose.spin_angle_rad - begin.pose.spin_angle_rad) / (2 * std::numbers::pi) /
                         (end.time_s - begin.time_s);
  const double frames_per_turn = spin_hz > 0 ? rate_hz / spin_hz : 0;
  if (!(frames_per_turn >= 2) || static_cast<double>(count) < (kMinTurns + 1) * frames_per_turn) return out;
  const auto turn = static_cast<std::size_t>(std::lround(frames_per_turn));
  const std::vector<double> values = without_mean(log, first, count, turn);
  out.spin_hz = spin_hz;
  out.lines = welch(values, std::min(values.size(), kWindowTurns * turn), rate_hz);
  out.peaks = find_peaks(out.lines, spin_hz);
  return out;
}

bool write_torque_spectrum(const std::string& dir) {
  const TorqueSpectrum spectrum = torque_spectrum(read_force_log(dir + "/forces.csv"));
  if (spectrum.lines.empty()) return false;
  CsvWriter csv = plot_csv(dir, "spectrum.csv", "frequency_hz,frequency_per_spin,spin_torque_nmm");
  for (const auto& [frequency_hz, torque_nmm] : spectrum.lines) {
    csv.row({frequency_hz, frequency_hz / spectrum.spin_hz, torque_nmm});
  }
  csv.close();
  draw_plot(dir, "plots/spectrum", peaks_block(spectrum), embedded::spectrum_script);
  return true;
}

}  // namespace reamsim
