// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/presets.h"

#include <algorithm>
#include <array>
#include <string>

namespace reamsim {

namespace {

/// The specific energy u0·(density/1.8)^p at the ends and in the middle of the ranges that the project assumes
/// (docs/physics.md, section 4; no bounds of a result). A high exponent makes soft bone cheap to cut, so the least
/// energy goes with the highest exponent.
struct Preset {
  EnergyPreset name;
  double specific_energy_j_mm3;
  double density_exponent;
};
constexpr std::array<Preset, 3> kPresets{{{EnergyPreset::literature_low, 0.05, 2.5},
                                          {EnergyPreset::literature_mid, 0.15, 2},
                                          {EnergyPreset::literature_high, 0.30, 1}}};
constexpr double kReferenceDensity = 1.8;

/// A key that presets set, and its value in one of them.
struct PresetKey {
  std::string_view name;
  double CuttingSettings::*member;
  double value;
};

std::vector<PresetKey> keys_of(EnergyPreset preset) {
  const auto* const found = std::ranges::find(kPresets, preset, &Preset::name);
  if (found == kPresets.end()) return {};
  return {{"specific_energy_j_mm3", &CuttingSettings::specific_energy_j_mm3, found->specific_energy_j_mm3},
          {"reference_density_g_cm3", &CuttingSettings::reference_density_g_cm3, kReferenceDensity},
          {"density_exponent", &CuttingSettings::density_exponent, found->density_exponent}};
}

}  // namespace

void apply_preset(const KeyLocations& locations, CuttingSettings& cutting) {
  for (const PresetKey& key : keys_of(cutting.preset)) {
    if (!locations.given("cutting." + std::string(key.name))) cutting.*key.member = key.value;
  }
}

std::vector<std::string_view> changed_from_preset(const CuttingSettings& cutting) {
  std::vector<std::string_view> out;
  for (const PresetKey& key : keys_of(cutting.preset)) {
    if (cutting.*key.member != key.value) out.push_back(key.name);
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

}  // namespace reamsim
