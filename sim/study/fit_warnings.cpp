// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/fit_warnings.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "sim/scenario/find_key.h"
#include "sim/scenario/presets.h"

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

/// The measured columns with their units.
std::string columns_of(const ForceFit& fit) {
  std::string out;
  for (const ChannelResidual& r : fit.residuals) {
    const std::string column = column_of(r.channel);
    out += fmt::format("{}{} in {}", out.empty() ? "" : ", ", column, column.ends_with("_nmm") ? "N mm" : "N");
  }
  return out;
}

/// One sentence for all columns: the fit follows the column with the least noise, so that the unit of that one may be
/// wrong where another one is explained badly.
std::optional<std::string> column_warning(const ForceFit& fit) {
  std::string poor;
  int count = 0;
  for (const ChannelResidual& r : fit.residuals) {
    if (!(r.r_squared < kWorseThanMean)) continue;
    poor += fmt::format("{}{}: R2 is {:.3g}", count == 0 ? "" : ", ", column_of(r.channel), r.r_squared);
    ++count;
  }
  if (count == 0) return std::nullopt;
  return fmt::format(
      "{}: the fitted law explains {}; check sign and unit of every measured column ({}), because a wrong one spoils "
      "the fit of the others, and that time_s begins with the run",
      poor, count == 1 ? "it worse than its mean does" : "them worse than their means do", columns_of(fit));
}

std::vector<std::string> refused_constants(const ForceFit& fit) {
  std::vector<std::string> out;
  for (const FittedConstant& c : fit.constants) {
    const std::string key = key_of(c.name);
    const Range& range = find_key(key, {}).info.range;
    if (!c.fitted || c.at_bound || range.contains(c.value)) continue;
    out.push_back(
        fmt::format("{} is {:.6g}, and {} accepts {}: a scenario would refuse it; check the unit of every measured "
                    "column ({})",
                    c.name, c.value, key, range_text(range), columns_of(fit)));
  }
  return out;
}

/// Specific energies beside which the unit of the measured columns is likelier to be wrong than the bone to be unusual,
/// J/mm3: a tenth of the least that the project assumes at a density, and several times that of the thinnest chips
/// (docs/physics.md, section 4).
Range usual_energy(double density_g_cm3) {
  constexpr double kOfLeast = 0.1, kMost = 20;
  CuttingSettings low;
  low.preset = EnergyPreset::literature_low;
  apply_preset({}, low);
  const double relative = std::min(density_g_cm3 / low.reference_density_g_cm3, 1.0);
  return {kOfLeast * low.specific_energy_j_mm3 * std::pow(relative, low.density_exponent), kMost};
}

/// The specific energies of a fit, each at the density of the bone that tells it: u0 itself may be extrapolated.
struct EnergyAt {
  std::string constant;
  double j_mm3;
  double density_g_cm3;
};

std::vector<EnergyAt> energies_of(const ForceFit& fit, double reference_density_g_cm3) {
  std::vector<EnergyAt> out;
  double mass = 0, volume = 0;
  for (std::size_t i = 0; i < fit.classes.size(); ++i) {
    const DensityClass& of = fit.classes[i];
    mass += of.mean_g_cm3 * of.volume_mm3;
    volume += of.volume_mm3;
    if (fit.constants[i].name == "u" + std::to_string(i + 1)) {
      out.push_back({fit.constants[i].name, fit.constants[i].value, of.mean_g_cm3});
    }
  }
  if (fit.constants[0].name != "u0" || !(volume > 0)) return out;
  const double density = mass / volume;
  out.push_back({"u0", fit.of("u0").value * std::pow(density / reference_density_g_cm3, fit.of("p").value), density});
  return out;
}

std::vector<std::string> unusual_energies(const ForceFit& fit, double reference_density_g_cm3) {
  std::vector<std::string> out;
  for (const EnergyAt& at : energies_of(fit, reference_density_g_cm3)) {
    const Range usual = usual_energy(at.density_g_cm3);
    if (at.j_mm3 <= 0 || usual.contains(at.j_mm3)) continue;
    out.push_back(
        fmt::format("{}: the bone of {:.3g} g/cm3 takes {:.3g} J/mm3, far {} what is usual for bone ({:.2g} to {:g} "
                    "J/mm3); check the unit of every measured column ({})",
                    at.constant, at.density_g_cm3, at.j_mm3, at.j_mm3 < usual.min ? "below" : "above", usual.min,
                    usual.max, columns_of(fit)));
  }
  return out;
}

}  // namespace

std::vector<std::string> fit_warnings(const ForceFit& fit, double reference_density_g_cm3) {
  std::vector<std::string> out = refused_constants(fit);
  if (out.empty()) out = unusual_energies(fit, reference_density_g_cm3);
  if (const auto columns = column_warning(fit)) out.insert(out.begin(), *columns);
  return out;
}

}  // namespace reamsim
