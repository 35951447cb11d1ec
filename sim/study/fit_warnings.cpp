// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/fit_warnings.h"

#include <fmt/core.h>

#include <array>
#include <utility>

#include "sim/scenario/find_key.h"

namespace reamsim {

namespace {

/// A larger R² may come from noise about a mean that the law explains well.
constexpr double kWorseThanMean = -0.05;

/// The scenario key of a constant of a fit.
std::string key_of(const std::string& constant) {
  static constexpr std::array<std::pair<const char*, const char*>, 5> kKeys{
      {{"u0", "cutting.specific_energy_j_mm3"},
       {"p", "cutting.density_exponent"},
       {"k_n", "cutting.normal_ratio"},
       {"K_t", "cutting.edge_force.tangential_n_mm"},
       {"K_n", "cutting.edge_force.normal_n_mm"}}};
  for (const auto& [name, key] : kKeys)
    if (constant == name) return key;
  return "cutting.specific_energy_table.0.energy_j_mm3";  // u1, u2, ...: of classes
}

}  // namespace

std::vector<std::string> fit_warnings(const ForceFit& fit) {
  std::vector<std::string> out;
  for (const ChannelResidual& r : fit.residuals) {
    if (!(r.r_squared < kWorseThanMean)) continue;
    const std::string column = column_of(r.channel);
    out.push_back(
        fmt::format("{}: R2 is {:.3g}: the fitted law explains it worse than its mean does; check its sign and "
                    "its unit ({}), and that time_s begins with the run",
                    column, r.r_squared, column.ends_with("_nmm") ? "N mm" : "N"));
  }
  for (const FittedConstant& c : fit.constants) {
    const std::string key = key_of(c.name);
    const Range& range = find_key(key, {}).info.range;
    if (!c.fitted || c.at_bound || range.contains(c.value)) continue;
    out.push_back(fmt::format(
        "{} is {:.6g}, and {} accepts {}: a scenario would refuse it; check the unit of the measured columns", c.name,
        c.value, key, range_text(range)));
  }
  return out;
}

}  // namespace reamsim
