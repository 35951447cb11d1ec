// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/parse.h"

#include <array>
#include <utility>

namespace reamsim {

namespace {

/// A key that presets set, with its values at the low end, in the middle and at the high end of the specific energies
/// u0·(density/1.8)^p that the project assumes (docs/physics.md, section 4; no bounds of a result). The higher
/// the exponent, the lower the specific energy of bone of low density: the lowest energies have the highest exponent.
struct PresetKey {
  std::string_view name;
  double CuttingSettings::*member;
  std::array<double, 3> values;

  [[nodiscard]] double value(EnergyPreset preset) const { return values[static_cast<std::size_t>(preset) - 1]; }
};
constexpr std::array<PresetKey, 3> kPresetKeys{
    {{"specific_energy_j_mm3", &CuttingSettings::specific_energy_j_mm3, {0.05, 0.15, 0.30}},
     {"reference_density_g_cm3", &CuttingSettings::reference_density_g_cm3, {1.8, 1.8, 1.8}},
     {"density_exponent", &CuttingSettings::density_exponent, {2.5, 2, 1}}}};

}  // namespace

void apply_preset(const KeyLocations& locations, CuttingSettings& cutting) {
  if (cutting.preset == EnergyPreset::none) return;
  for (const PresetKey& key : kPresetKeys) {
    if (!locations.given("cutting." + std::string(key.name))) cutting.*key.member = key.value(cutting.preset);
  }
}

std::vector<std::string_view> changed_from_preset(const CuttingSettings& cutting) {
  std::vector<std::string_view> out;
  if (cutting.preset == EnergyPreset::none) return out;
  for (const PresetKey& key : kPresetKeys) {
    if (cutting.*key.member != key.value(cutting.preset)) out.push_back(key.name);
  }
  return out;
}

void apply_walch_defaults(PhantomSettings& phantom) {
  if (phantom.walch == Walch::none) return;
  if (phantom.walch == Walch::c) {
    phantom.version_deg = 37;
    phantom.inclination_deg = 3;
    phantom.face_radius_mm = 37;
    phantom.height_mm = 46;
    phantom.width_mm = 30;
    return;
  }
  phantom.version_deg = 8;
  phantom.inclination_deg = 8;
  if (phantom.walch == Walch::a1) phantom.medialization_mm = 1.5;
  if (phantom.walch == Walch::a2) phantom.medialization_mm = 6;
}

void apply_format_defaults(CsvMotionSettings& csv) {
  if (csv.format != PoseFormat::tum) return;
  csv.separator = Separator::space;
  csv.time_column = "1";
  csv.position_columns = {"2", "3", "4"};
  csv.position_unit = LengthUnit::m;
  csv.quaternion_columns = {"5", "6", "7", "8"};
  csv.quaternion_order = QuaternionOrder::xyzw;
}

Mat3 TransformSettings::rotation_matrix() const {
  Mat3 out;
  for (Eigen::Index i = 0; i < 3; ++i) out.row(i) = rotation[static_cast<std::size_t>(i)].transpose();
  return out;
}

Rigid TransformSettings::rigid() const {
  Rigid out = Rigid::Identity();
  if (quaternion) out.linear() = quaternion->toRotationMatrix();
  if (!rotation.empty()) out.linear() = Quat(rotation_matrix()).normalized().toRotationMatrix();
  out.translation() = translation_mm;
  return out;
}

std::vector<PassSpec> passes_of(const Scenario& scenario) {
  if (scenario.motion.passes.empty()) return {{scenario.tool, scenario.motion, "tool", "motion"}};
  std::vector<PassSpec> out;
  for (std::size_t i = 0; i < scenario.motion.passes.size(); ++i) {
    const PassSettings& pass = scenario.motion.passes[i];
    const std::string key = "motion.passes." + std::to_string(i);
    PassSpec spec{pass.tool.value_or(scenario.tool), scenario.motion, pass.tool ? key + ".tool" : "tool", key};
    spec.motion.passes.clear();
    spec.motion.plunge = pass.plunge;
    out.push_back(spec);
  }
  return out;
}

InputError in_pass(const PassSpec& pass, const InputError& error) {
  std::vector<Mistake> mistakes = error.mistakes();
  for (Mistake& mistake : mistakes) {
    std::string& key = mistake.key;
    if (key.starts_with("tool.")) key.replace(0, 4, pass.tool_key);
    if (key.starts_with("motion.plunge")) key.replace(0, 6, pass.motion_key);
  }
  return InputError(std::move(mistakes));
}

}  // namespace reamsim
