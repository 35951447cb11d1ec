#include "render/force_log.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string_view>

#include "sim/base/error.h"
#include "sim/record/layer_mean.h"

namespace reamsim {
namespace {

enum Column { kFrame, kTime, kX, kY, kZ, kQw, kQx, kQy, kQz, kSpinAngle, kDepth, kAxial, kTorque, kRemoved, kColumns };

constexpr std::array<std::string_view, kColumns> kNames{
    "frame",   "time_s",  "tool_x_mm",      "tool_y_mm", "tool_z_mm",     "tool_qw",         "tool_qx",
    "tool_qy", "tool_qz", "spin_angle_rad", "depth_mm",  "axial_force_n", "spin_torque_nmm", "removed_mm3"};

std::vector<std::string_view> split(std::string_view line) {
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  std::vector<std::string_view> cells;
  for (;;) {
    const std::size_t comma = line.find(',');
    cells.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

/// Where each wanted column stands.
std::array<std::size_t, kColumns> find_columns(const std::string& path, std::string_view header) {
  const auto names = split(header);
  std::array<std::size_t, kColumns> places{};
  for (std::size_t i = 0; i < kColumns; ++i) {
    const auto found = std::find(names.begin(), names.end(), kNames[i]);
    if (found == names.end()) {
      throw InputError({path, 1, 0}, std::string(kNames[i]), "no such column", "the forces.csv of a run");
    }
    places[i] = static_cast<std::size_t>(found - names.begin());
  }
  return places;
}

double number(const SourceLocation& where, std::string_view name, std::string_view cell) {
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value)) {
    throw InputError(where, std::string(name), "found '" + std::string(cell.substr(0, 40)) + "'",
                     "expected a finite number");
  }
  return value;
}

ForceRow parse_row(const SourceLocation& where, const std::array<std::size_t, kColumns>& places,
                   std::string_view line) {
  const auto cells = split(line);
  std::array<double, kColumns> v{};
  for (std::size_t i = 0; i < kColumns; ++i) {
    if (places[i] >= cells.size()) {
      throw InputError(where, std::string(kNames[i]), "the line ends after " + std::to_string(cells.size()) + " cells",
                       "expected as many as in the header");
    }
    v[i] = number(where, kNames[i], cells[places[i]]);
  }
  ForceRow row;
  if (v[kFrame] < 0 || v[kFrame] > 1e15) throw InputError(where, "frame", "out of range", "expected 0 or more");
  row.frame = static_cast<std::int64_t>(v[kFrame]);
  row.time_s = v[kTime];
  row.pose.position_mm = Vec3(v[kX], v[kY], v[kZ]);
  row.pose.orientation = Quat(v[kQw], v[kQx], v[kQy], v[kQz]);
  if (std::abs(row.pose.orientation.norm() - 1) > 1e-3) {
    throw InputError(where, "tool_qw", "the quaternion is not of length 1", "expected a rotation");
  }
  row.pose.orientation.normalize();
  row.pose.spin_angle_rad = v[kSpinAngle];
  row.depth_mm = v[kDepth];
  row.axial_force_n = v[kAxial];
  row.spin_torque_nmm = v[kTorque];
  row.removed_mm3 = v[kRemoved];
  return row;
}

}  // namespace

const ForceRow& ForceLog::at(std::int64_t frame, const std::string& path) const {
  const auto after = std::upper_bound(rows.begin(), rows.end(), frame,
                                      [](std::int64_t wanted, const ForceRow& row) { return wanted < row.frame; });
  if (after == rows.begin()) return rows.front();
  const ForceRow& row = *std::prev(after);
  if (row.frame != frame) {
    throw InputError({path, 0, 0}, "frame", "there is no row for frame " + std::to_string(frame) + " of snapshots/",
                     "run the scenario again");
  }
  return row;
}

ForceLog read_force_log(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string line;
  if (!in || !std::getline(in, line)) throw InputError({path, 0, 0}, "", "cannot be read", "the forces.csv of a run");
  const auto places = find_columns(path, line);
  ForceLog log;
  double removed_mm3 = 0;
  for (int number_of_line = 2; std::getline(in, line); ++number_of_line) {
    if (line.empty()) continue;
    ForceRow row = parse_row({path, number_of_line, 0}, places, line);
    if (!log.rows.empty() && row.frame <= log.rows.back().frame) {
      throw InputError({path, number_of_line, 0}, "frame", "frames do not ascend", "the forces.csv of a run");
    }
    removed_mm3 += row.removed_mm3;
    row.removed_mm3 = removed_mm3;
    log.rows.push_back(row);
  }
  if (log.rows.empty()) throw InputError({path, 0, 0}, "", "has no row", "run the scenario again");
  return log;
}

void add_layer_means(ForceLog& log, double voxel_mm) {
  LayerMean mean(voxel_mm);
  for (ForceRow& row : log.rows) {
    const auto means = mean.add(row.pose.position_mm, row.axial_force_n, row.spin_torque_nmm);
    row.layer_axial_force_n = means.axial_force_n;
    row.layer_spin_torque_nmm = means.spin_torque_nmm;
    row.layer_frames = means.frames;
  }
}

}  // namespace reamsim
