// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/measured_forces.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/base/csv.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/text.h"

namespace reamsim {

namespace {

constexpr std::array<std::string_view, kForceChannels> kChannelColumns{
    "force_x_n",    "force_y_n",    "force_z_n",     "torque_x_nmm",
    "torque_y_nmm", "torque_z_nmm", "axial_force_n", "spin_torque_nmm"};

constexpr const char* kExpected = "a CSV file with time_s and any of axial_force_n, spin_torque_nmm, force_x_n, ...";

/// The channels among the columns of a file.
std::vector<ForceChannel> channels_in(const std::vector<std::string_view>& names) {
  const auto has = [&](int channel) {
    return std::ranges::find(names, kChannelColumns[static_cast<std::size_t>(channel)]) != names.end();
  };
  std::vector<ForceChannel> out;
  for (int i = 0; i < 6; ++i)
    if (has(i)) out.push_back(static_cast<ForceChannel>(i));
  if (has(6) && !(has(0) && has(1) && has(2))) out.push_back(ForceChannel::axial_force);
  if (has(7) && !(has(3) && has(4) && has(5))) out.push_back(ForceChannel::spin_torque);
  return out;
}

/// A cell as a number; NaN where it is empty.
double cell_value(std::string_view cell, const SourceLocation& where, std::string_view column) {
  if (cell.empty()) return std::nan("");
  char* end = nullptr;
  const std::string text(cell);
  const double value = std::strtod(text.c_str(), &end);
  if (end == text.c_str() + text.size() && std::isfinite(value)) return value;
  throw InputError(where, std::string(column), "is not a finite number", "expected a number or an empty cell");
}

std::size_t place_of(const std::vector<std::string_view>& names, std::string_view name) {
  return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
}

}  // namespace

std::string column_of(ForceChannel channel) {
  return std::string(kChannelColumns[static_cast<std::size_t>(channel)]);
}

MeasuredForces read_measured_forces(const std::string& path) {
  const std::string text = read_file(path, kExpected);
  const std::string header = csv_header(text.substr(0, text.find('\n')), {path, 1, 0});
  const std::vector<std::string_view> names = csv_cells(header);
  MeasuredForces out{.channels = channels_in(names), .time_s = {}, .values = {}, .file = path};
  out.values.resize(out.channels.size());
  const std::size_t time = place_of(names, "time_s");
  if (time == names.size())
    throw InputError({path, 1, 0}, "time_s", "column missing", std::string("expected ") + kExpected);
  if (out.channels.empty())
    throw InputError({path, 1, 0}, "", "no measured column", std::string("expected ") + kExpected);
  int number = 1;
  for (std::size_t begin = text.find('\n'); begin != std::string::npos && begin + 1 < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin + 1), text.size());
    const std::string_view line(text.data() + begin + 1, end - begin - 1);
    begin = end;
    ++number;
    const std::vector<std::string_view> cells = csv_cells(line);
    if (line.empty() || line == "\r") continue;
    const SourceLocation where{path, number, 0};
    if (cells.size() == 1) refuse_other_separator(line, where);
    if (cells.size() < names.size())
      throw InputError(where, "", "has fewer cells than the header", "expected a cell for each column");
    const double t = cell_value(cells[time], where, "time_s");
    if (std::isnan(t) || (!out.time_s.empty() && t <= out.time_s.back()))
      throw InputError(where, "time_s", "does not ascend", "expected ascending times");
    out.time_s.push_back(t);
    for (std::size_t c = 0; c < out.channels.size(); ++c) {
      const std::string column = column_of(out.channels[c]);
      out.values[c].push_back(cell_value(cells[place_of(names, column)], where, column));
    }
  }
  if (out.time_s.empty()) throw InputError({path, 0, 0}, "", "has no rows", std::string("expected ") + kExpected);
  return out;
}

}  // namespace reamsim
