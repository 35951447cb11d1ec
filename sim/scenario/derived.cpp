// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/parse.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <set>
#include <utility>

#include "sim/base/text.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

/// A key that presets set, with its values: low end, middle and high end of the specific energies u0·(density/1.8)^p
/// that the project assumes (docs/physics.md, 4; no bounds of a result; the lowest have the highest exponent, so that
/// bone of low density has the least), then those fitted to the forces of a drill in human and artificial femurs
/// (MacAvelia et al. 2012, doi:10.1115/1.4007953; docs/validation.md), whose exponent is assumed.
struct PresetKey {
  std::string_view name;
  double CuttingSettings::*member;
  std::array<double, 5> values;

  [[nodiscard]] double value(EnergyPreset preset) const { return values[static_cast<std::size_t>(preset) - 1]; }
};
constexpr std::array<PresetKey, 4> kPresetKeys{
    {{"specific_energy_j_mm3", &CuttingSettings::specific_energy_j_mm3, {0.05, 0.15, 0.30, 0.9361, 0.2806}},
     {"reference_density_g_cm3", &CuttingSettings::reference_density_g_cm3, {1.8, 1.8, 1.8, 1.8, 1.8}},
     {"density_exponent", &CuttingSettings::density_exponent, {2.5, 2, 1, 2, 2}},
     {"normal_ratio", &CuttingSettings::normal_ratio, {0.5, 0.5, 0.5, 0.3829, 0.6836}}}};

/// Of the same drill, which has two cutting edges.
std::optional<EdgeForceSettings> preset_edge_force(EnergyPreset preset) {
  if (preset == EnergyPreset::drill_human_femur) return EdgeForceSettings{15.48, 41.57, 2};
  if (preset == EnergyPreset::drill_artificial_femur) return EdgeForceSettings{8.831, 17.09, 2};
  return std::nullopt;
}

/// What a CT is read from: for a DICOMDIR the folder that it indexes.
std::string ct_input(const std::string& path) {
  const fs::path file(path);
  const bool index = lower_case(file.filename().string()) == "dicomdir" && fs::is_regular_file(file);
  return index ? file.parent_path().string() : path;
}

/// Frames if the settings give no number, the first and the last included.
constexpr std::int64_t kStills = 8, kStillsOfPasses = 11;
constexpr std::int64_t kFilmPictures = 150;
/// Margin around the contact, parts of it: 1/20.
constexpr std::int64_t kMarginParts = 20;

/// The i-th of the frames of all spans.
std::int64_t frame_of(const FrameSpans& spans, std::int64_t i) {
  for (const FrameSpan& span : spans) {
    const std::int64_t frames = span.last - span.first + 1;
    if (i < frames) return span.first + i;
    i -= frames;
  }
  return spans.back().last;
}

/// More where several passes are to be seen.
std::int64_t stills_of(const FrameSpans& contact) {
  return contact.size() > 1 ? kStillsOfPasses : kStills;
}

/// 0, `last`, and between them as many in contact as make the number of stills.
std::vector<std::int64_t> spread_over(FrameSpans contact, std::int64_t last) {
  std::int64_t frames = 0;
  for (FrameSpan& span : contact) {
    span.first = std::clamp<std::int64_t>(span.first, 0, last);
    span.last = std::clamp(span.last, span.first, last);
    frames += span.last - span.first + 1;
  }
  const int ends = (contact.front().first > 0 ? 1 : 0) + (contact.back().last < last ? 1 : 0);
  const std::int64_t steps = stills_of(contact) - ends - 1;
  std::set<std::int64_t> out{0, last};
  for (std::int64_t i = 0; i <= steps; ++i) out.insert(frame_of(contact, (2 * i * (frames - 1) + steps) / (2 * steps)));
  return {out.begin(), out.end()};
}

bool is_near(const FrameSpan& contact, std::int64_t frame) {
  const std::int64_t margin = 1 + (contact.last - contact.first) / kMarginParts;
  return frame >= contact.first - margin && frame <= contact.last + margin;
}

}  // namespace

void apply_preset(const KeyLocations& locations, CuttingSettings& cutting) {
  if (cutting.preset == EnergyPreset::none) return;
  for (const PresetKey& key : kPresetKeys) {
    if (!locations.given("cutting." + std::string(key.name))) cutting.*key.member = key.value(cutting.preset);
  }
  if (!cutting.edge_force) cutting.edge_force = preset_edge_force(cutting.preset);
}

std::vector<std::string_view> changed_from_preset(const CuttingSettings& cutting) {
  std::vector<std::string_view> out;
  if (cutting.preset == EnergyPreset::none) return out;
  for (const PresetKey& key : kPresetKeys) {
    if (cutting.*key.member != key.value(cutting.preset)) out.push_back(key.name);
  }
  const auto edge = preset_edge_force(cutting.preset);
  if (edge && cutting.edge_force != edge) out.push_back("edge_force");
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

std::vector<std::pair<std::string, std::string>> input_files(const Scenario& scenario) {
  const BoneSettings& bone = scenario.bone;
  std::vector<std::pair<std::string, std::string>> files;
  if (bone.source == BoneSource::ct) {
    files.emplace_back("bone.ct.path", ct_input(bone.ct.path));
    if (bone.ct.label_map) files.emplace_back("bone.ct.label_map.path", bone.ct.label_map->path);
  }
  if (bone.source == BoneSource::mesh) files.emplace_back("bone.mesh.path", bone.mesh.path);
  if (bone.source == BoneSource::vdb) files.emplace_back("bone.vdb.path", bone.vdb.path);
  files.emplace_back("tool.mesh", scenario.tool.mesh);
  for (const PassSpec& pass : passes_of(scenario)) {
    if (pass.tool_key != "tool") files.emplace_back(pass.tool_key + ".mesh", pass.tool.mesh);
  }
  if (scenario.clearance.envelope) files.emplace_back("clearance.envelope.path", scenario.clearance.envelope->path);
  const auto& implant = scenario.metrics.implant;
  if (implant && implant->mesh) files.emplace_back("metrics.implant.mesh.path", implant->mesh->path);
  if (scenario.motion.csv) files.emplace_back("motion.csv.path", scenario.motion.csv->path);
  if (scenario.motion.push && !scenario.motion.push->profile.empty())
    files.emplace_back("motion.push.profile", scenario.motion.push->profile);
  for (const MarkupsSource& source : scenario.markups) {
    const auto same = [&](const auto& file) { return file.second == source.path; };
    if (std::ranges::none_of(files, same)) files.emplace_back(source.key, source.path);
  }
  return files;
}

std::vector<std::string> draft_overrides(const Scenario& scenario) {
  std::vector<std::string> out{"name=" + json_string(scenario.name + "-draft"), "output.vti=false",
                               "output.meshes=false", "output.plots=false"};
  if (scenario.bone.source != BoneSource::vdb) {
    out.push_back("bone.voxel_mm=" + shortest_text(std::min(2 * scenario.bone.voxel_mm, BoneSettings::kMostVoxel_mm)));
  }
  const std::string cameras = scenario.render.cameras.empty() ? "" : name_of(scenario.render.cameras.front());
  out.insert(out.end(), {"render.every_frames=1000000000", "render.cameras=[" + cameras + "]",
                         "render.before_after=false", "render.contact_sheet=false", "render.user_cameras=[]",
                         "render.turntable_pictures=0", "render.film=none", "render.report=false"});
  return out;
}

std::vector<std::int64_t> picture_frames(const RenderSettings& settings, std::int64_t last, const FrameSpans& contact) {
  const bool film = settings.enabled && settings.film != FilmFormat::none;
  if (settings.every_frames == 0 && !film && !contact.empty()) return spread_over(contact, last);
  const std::int64_t pictures = film ? kFilmPictures : stills_of(contact) - 1;
  const std::int64_t spread = std::max<std::int64_t>(1, (last + pictures - 1) / pictures);
  const std::int64_t interval = settings.every_frames > 0 ? settings.every_frames : spread;
  std::vector<std::int64_t> out;
  for (std::int64_t frame = 0; frame < last; frame += interval) out.push_back(frame);
  out.push_back(last);
  return out;
}

std::vector<std::int64_t> in_contact(const std::vector<std::int64_t>& frames, const FrameSpans& contact) {
  if (contact.empty()) return frames;
  std::vector<std::int64_t> out;
  std::ranges::copy_if(frames, std::back_inserter(out), [&](std::int64_t frame) {
    return std::ranges::any_of(contact, [frame](const FrameSpan& span) { return is_near(span, frame); });
  });
  return out.size() < 2 ? frames : out;
}

std::vector<std::int64_t> evenly_among(const std::vector<std::int64_t>& frames, std::size_t most) {
  const std::size_t count = std::min(frames.size(), most);
  if (count < 2) return frames;
  std::vector<std::int64_t> out;
  for (std::size_t i = 0; i < count; ++i) {
    out.push_back(frames[(2 * i * (frames.size() - 1) + count - 1) / (2 * (count - 1))]);
  }
  return out;
}

std::vector<std::int64_t> still_frames(const std::vector<std::int64_t>& frames, const RenderSettings& settings,
                                       const FrameSpans& contact) {
  if (settings.film == FilmFormat::none || settings.every_frames > 0) return frames;
  const std::vector<std::int64_t> among = in_contact(frames, contact);
  const auto ends = std::int64_t{among.front() != frames.front()} + std::int64_t{among.back() != frames.back()};
  const std::vector<std::int64_t> spread = evenly_among(among, static_cast<std::size_t>(stills_of(contact) - ends));
  std::set<std::int64_t> out{frames.front(), frames.back()};
  out.insert(spread.begin(), spread.end());
  return {out.begin(), out.end()};
}

}  // namespace reamsim
