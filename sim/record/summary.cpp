// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/summary.h"

#include <sys/resource.h>

#include <algorithm>
#include <filesystem>

#include "sim/base/checksum.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/mesh/mesh_io.h"
#include "sim/record/output_folder.h"
#include "sim/record/result_json.h"
#include "sim/scenario/parse.h"
#include "sim/scenario/paths.h"

namespace reamsim {

REAMSIM_TO_JSON(SpecificEnergySettings, density_g_cm3, energy_j_mm3)
REAMSIM_TO_JSON(SizeEffectSettings, exponent, reference_mm, cutting_edges, least_mm, most_mm)
REAMSIM_TO_JSON(EdgeForceSettings, tangential_n_mm, normal_n_mm, cutting_edges)
REAMSIM_TO_JSON(FirstContact, travel_mm, bone_mm)
REAMSIM_TO_JSON(PassTotals, first_frame, last_frame, first_contact_frame, removed_mm3, energy_mj, max_depth_mm,
                peak_axial_force_n, peak_spin_torque_nmm)
REAMSIM_TO_JSON(PushEvent, frame, time_s, depth_mm, event, value)

namespace {

using Json = nlohmann::ordered_json;

/// Provenance in the metadata of the grids. Without device and time, so that the same scenario gives the same bytes.
Metadata provenance(const SimulationInput& scene, const RunFacts& facts) {
  Metadata out{{"program", "reamsim " REAMSIM_VERSION},
               {"scenario", scene.scenario.name},
               {"erosion", name_of(scene.scenario.cutting.erosion)}};
  for (const auto& input : facts.inputs) {
    out.emplace_back("input_" + input.role, std::filesystem::path(input.path).filename().string());
    out.emplace_back("sha256_" + input.role, input.sha256);
  }
  const Metadata anatomy = metadata_of({scene.bone.glenoid, scene.bone.landmarks, scene.bone.side});
  out.insert(out.end(), anatomy.begin(), anatomy.end());
  return out;
}

std::string checksum_line(const InputSum& input) {
  return "# sha256 " + input.sha256 + "  " + input.role + "  " + recorded_path(input.path) + "\n";
}

/// The first lines of scenario.yaml: program, device, and the file that the user wrote.
constexpr int kHeadLines = 2;

/// The other lines: what the results depend on. `inputs`: the scenario file first.
std::string scenario_body(const Scenario& scenario, const std::vector<InputSum>& inputs) {
  std::string out;
  for (std::size_t i = 1; i < inputs.size(); ++i) out += checksum_line(inputs[i]);
  return out + to_yaml(scenario);
}

/// Peak memory of the process, MB = 10⁶ bytes.
double peak_process_mb() {
  struct rusage usage {};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024 / 1e6;  // Linux counts KiB
}

Json force_law_json(const CuttingSettings& cutting) {
  Json json{{"preset", cutting.preset == EnergyPreset::none ? Json() : Json(name_of(cutting.preset))},
            {"changed_from_preset", changed_from_preset(cutting)}};
  if (cutting.specific_energy_table.empty()) {
    json["specific_energy_j_mm3"] = cutting.specific_energy_j_mm3;
    json["reference_density_g_cm3"] = cutting.reference_density_g_cm3;
    json["density_exponent"] = cutting.density_exponent;
  } else {
    json["specific_energy_table"] = cutting.specific_energy_table;
  }
  json["normal_ratio"] = cutting.normal_ratio;
  json["friction_fraction"] = cutting.friction_fraction;
  if (cutting.size_effect) json["size_effect"] = *cutting.size_effect;
  if (cutting.edge_force) json["edge_force"] = *cutting.edge_force;
  return json;
}

Json bone_json(const SimulationInput& scene, const RunTotals& totals, const RunFacts& facts) {
  const VoxelGrid& grid = scene.bone.voxmap->grid;
  return {{"voxel_mm", grid.voxel_mm},
          {"dims", grid.dims},
          {"bone_before_mm3", facts.bone_before_mm3},
          {"bone_after_mm3", scene.bone.view().bone_mm3()},
          {"removed_mm3", totals.removed_mm3}};
}

Json segmentation_json(const Segmentation& s) {
  Json json{{"method", s.method},
            {"threshold_hu", s.threshold_hu},
            {"bone_mm3", s.bone_mm3},
            {"below_threshold_fraction", s.below_threshold_fraction},
            {"density_lower_bound_fraction", s.lower_bound_fraction},
            {"noise_hu", s.noise_hu}};
  if (s.method == "threshold") {
    json.update({{"pieces", s.pieces},
                 {"kept", s.by_seed ? "seed" : "largest"},
                 {"kept_rank", s.kept_rank},
                 {"kept_piece_mm3", s.kept_piece_mm3},
                 {"largest_piece_mm3", s.largest_mm3},
                 {"second_piece_mm3", s.second_mm3},
                 {"dropped_mm3", s.dropped_mm3},
                 {"cut_mm3", s.cut_mm3},
                 {"closed_mm3", s.closed_mm3},
                 {"filled_mm3", s.filled_mm3}});
  }
  json["planes_through_mm"] = s.planes_through_mm;
  return json;
}

Json tool_json(const Tool& tool) {
  const auto of_shell = [&](const auto& value) { return tool.shell.codes.empty() ? Json() : Json(value); };
  Json json{{"shell_points", of_shell(tool.shell.codes.size())},
            {"shell_resolution", of_shell(tool.shell.resolution)},
            {"shell_spacing_mm", of_shell(tool.shell.cell_mm)}};
  if (const auto& teeth = tool.teeth) {
    json["distance_grid"] = {{"spacing_mm", teeth->spacing_mm},
                             {"bricks", teeth->stored_bricks()},
                             {"bytes", teeth->bytes()},
                             {"volume_mm3", teeth->volume_mm3},
                             {"mesh_volume_mm3", teeth->mesh_mm3},
                             {"volume_error", teeth->volume_error()}};
  }
  return json;
}

Json passes_json(const SimulationInput& scene, const RunTotals& totals) {
  Json json = Json::array();
  const std::vector<PassSpec> specs = passes_of(scene.scenario);
  for (std::size_t i = 0; i < totals.passes.size(); ++i) {
    json.push_back({{"pass", i + 1}, {"tool", recorded_path(specs[i].tool.mesh)}});
    json.back().update(Json(totals.passes[i]));
    if (const auto& contact = scene.first_contacts[i]) json.back()["plunge_contact"] = *contact;
  }
  return json;
}

Json push_json(const PushTotals& push) {
  Json json{{"mean_feed_mm_s", push.mean_feed_mm_s()},
            {"peak_feed_mm_s", push.peak_feed_mm_s},
            {"hand_work_mj", push.hand_mj},
            {"spindle_work_mj", push.spindle_work_mj},
            {"drill_work_mj", push.spindle_work_mj},  // the name of 1.0, until 2.0
            {"peak_hand_power_w", push.peak_hand_power_w},
            {"peak_drill_power_w", push.peak_drill_power_w}};
  if (const auto overshoot = push.overshoot_mm()) json["overshoot_mm"] = *overshoot;
  json["events"] = push.events();
  return json;
}

Json deflection_json(const DeflectionTotals& deflection) {
  return {{"peak_mm", deflection.peak_mm},
          {"peak_time_s", deflection.peak_time_s},
          {"peak_lateral_mm", deflection.peak_lateral_mm},
          {"at_depth_mm", deflection.at_depth_mm},
          {"lateral_at_depth_mm", deflection.at_depth_mm.head<2>().norm()},
          {"at_end_mm", deflection.at_end_mm}};
}

/// The figures that depend on the constants of the force law: of `json`, a summary, the old ones are replaced.
void put_force_law(const CuttingSettings& cutting, const RunTotals& totals, Json& json) {
  if (cutting.law == CuttingLaw::energy) json["force_law"] = force_law_json(cutting);
  // Where voxels are removed whole, single frames are spikes.
  const KeyResults headline = totals.headline(cutting.erosion != ErosionMode::exact);
  json["headline"] = {{"force_name", headline.force().name},
                      {"peak_axial_force_n", headline.peak_axial_force_n},
                      {"peak_spin_torque_nmm", headline.peak_spin_torque_nmm},
                      {"force_definition", headline.force_definition()},
                      {"depth_name", headline.depth().name},
                      {"depth_mm", headline.tool_depth_mm},
                      {"depth_definition", KeyResults::kDepthDefinition}};
}

void put_forces(const CuttingSettings& cutting, const RunTotals& totals, Json& json) {
  json["work_mj"] = totals.work_mj();
  json["energy_mj"] = totals.energy_mj;
  json["floor_energy_mj"] = totals.floor_energy_mj;
  if (cutting.law == CuttingLaw::energy) json["friction_energy_mj"] = cutting.friction_fraction * totals.energy_mj;
  json["balance"] = totals.balance;
  json["forces"] = {{"peak_layer_axial_force_n", totals.peak_layer_axial_force_n},
                    {"peak_layer_spin_torque_nmm", totals.peak_layer_spin_torque_nmm},
                    {"peak_force_n", totals.peak_force_n},
                    {"rms_force_n", totals.rms_force_n()},
                    {"mean_force_n", totals.means().force_n},
                    {"peak_axial_force_n", totals.peak_axial_force_n},
                    {"mean_axial_force_n", totals.means().axial_force_n},
                    {"peak_torque_nmm", totals.peak_torque_nmm},
                    {"rms_torque_nmm", totals.rms_torque_nmm()},
                    {"mean_torque_nmm", totals.means().torque_nmm},
                    {"peak_spin_torque_nmm", totals.peak_spin_torque_nmm},
                    {"mean_spin_torque_nmm", totals.means().spin_torque_nmm}};
}

Json totals_json(const SimulationInput& scene, const RunTotals& totals, const RunFacts& facts) {
  const CuttingSettings& cutting = scene.scenario.cutting;
  Json json{{"program", "reamsim " REAMSIM_VERSION},
            {"scenario", scene.scenario.name},
            {"device", facts.device},
            {"engine", name_of(engine_of(scene.scenario))},
            {"erosion", name_of(cutting.erosion)},
            {"law", name_of(cutting.law)}};
  put_force_law(cutting, totals, json);
  json.update({{"frames", totals.frames},
               {"contact_frames", totals.contact_frames},
               {"first_contact_frame", totals.first_contact_frame},
               {"simulated_s", totals.simulated_s},
               {"reaming_s", static_cast<double>(totals.reaming_frames()) * scene.motion.frame_s()},
               {"removed_mm3", totals.removed_mm3},
               {"max_depth_mm", totals.max_depth_mm}});
  put_forces(cutting, totals, json);
  if (totals.push) json["push"] = push_json(*totals.push);
  if (totals.deflection) json["deflection"] = deflection_json(*totals.deflection);
  if (!scene.scenario.motion.passes.empty()) {
    json["passes"] = passes_json(scene, totals);
  } else if (const auto contact = scene.first_contact()) {
    json["plunge_contact"] = *contact;
  }
  return json;
}

std::string text_of_summary(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::vector<InputSum> input_sums(const Scenario& scenario) {
  std::vector<InputSum> sums{{"scenario", scenario.file, sha256_of(scenario.file)}};
  for (const auto& [role, path] : input_files(scenario)) sums.push_back({role, path, sha256_of(path)});
  return sums;
}

void write_tools(const std::string& dir, const SimulationInput& scene) {
  const std::string folder = dir + "/snapshots";
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw RunError(folder + ": " + error.message());
  write_stl(tool_path(dir, scene.motion.pass), scene.tool.mesh);
  for (const Pass& pass : scene.later_passes) write_stl(tool_path(dir, pass.motion.pass), pass.tool.mesh);
}

void write_scenario(const std::string& dir, const SimulationInput& scene, const RunFacts& facts) {
  std::string head = "# Resolved by reamsim " REAMSIM_VERSION ", with all defaults. Run on " + facts.device + ".";
  for (const auto& contact : scene.first_contacts) {
    if (contact) head += " Found: " + sentence_of(*contact) + ".";
  }
  write_file(dir + "/scenario.yaml",
             head + "\n" + checksum_line(facts.inputs.front()) + scenario_body(scene.scenario, facts.inputs));
}

bool is_result_of(const std::string& dir, const Scenario& scenario) {
  const std::string file = dir + "/scenario.yaml", text = read_file(file, "the scenario.yaml of a run");
  Scenario resolved = scenario;
  if (scenario.bone.source == BoneSource::vdb) {  // whose side and voxels are known only when it has been read
    const BoneSettings written = parse_scenario(file, {}).bone;
    if (scenario.bone.side == BodySide::unknown) resolved.bone.side = written.side;
    resolved.bone.voxel_mm = written.voxel_mm;
  }
  std::size_t body = 0;
  for (int line = 0; line < kHeadLines; ++line) body = std::min(text.size(), text.find('\n', body)) + 1;
  const auto without_device = [](const std::string& yaml) {  // a study may divide its runs among devices anew
    const std::size_t at = std::min(yaml.find("\n  device: "), yaml.size());
    return yaml.substr(0, at) + yaml.substr(std::min(yaml.find('\n', at + 1), yaml.size()));
  };
  return body <= text.size() &&
         without_device(text.substr(body)) == without_device(scenario_body(resolved, input_sums(scenario)));
}

void write_results(const std::string& dir, const SimulationInput& scene, const Recorder& recorder,
                   const RunFacts& facts) {
  write_bone_vdb(dir + "/reamed.vdb", scene.bone, recorder.removed_frames(), provenance(scene, facts));
  if (scene.scenario.output.vti) write_vti(dir + "/reamed.vti", scene.bone);
  if (scene.scenario.output.segmentation) write_segmentation(dir + "/reamed.seg.nrrd", scene.bone);
  write_depth_map(dir + "/depth_map.csv", facts.depth_map);
  write_file(dir + "/planning.mrk.json", planning_markups(scene, facts.metrics, recorder.totals().deepest_pose));
  if (recorder.totals().push) write_push_events(dir, *recorder.totals().push);
}

std::string reforced_summary(const std::string& dir, const CuttingSettings& cutting, const RunTotals& totals) {
  const std::string path = dir + "/summary.json";
  Json json = parse_result_json(read_file(path, "the summary of a run"));
  if (!json.is_object()) throw InputError({path, 0, 0}, "", "is damaged", "expected the summary of a run");
  put_force_law(cutting, totals, json);
  put_forces(cutting, totals, json);
  const std::size_t passes = json.contains("passes") && json["passes"].is_array() ? json["passes"].size() : 0;
  for (std::size_t i = 0; i < std::min(passes, totals.passes.size()); ++i) {
    json["passes"][i]["energy_mj"] = totals.passes[i].energy_mj;
    json["passes"][i]["peak_axial_force_n"] = totals.passes[i].peak_axial_force_n;
    json["passes"][i]["peak_spin_torque_nmm"] = totals.passes[i].peak_spin_torque_nmm;
  }
  json["forces_from_basis"] = true;
  return text_of_summary(json);
}

void write_summary(const std::string& dir, const SimulationInput& scene, const RunTotals& totals, const RunFacts& facts,
                   bool finished) {
  Json json = totals_json(scene, totals, facts);
  if (finished) {
    json["metrics"] = metrics_json(facts.metrics);
  } else {
    json["finished"] = false;
  }
  json["bone"] = bone_json(scene, totals, facts);
  if (scene.bone.segmentation) json["segmentation"] = segmentation_json(*scene.bone.segmentation);
  json["tool"] = tool_json(scene.tool);
  if (facts.clearance) json["clearance"] = clearance_json(*facts.clearance, scene);
  if (finished) {
    if (!facts.render_context.empty()) json["render"] = {{"context", facts.render_context}};
    json["timings_s"] = {{"load", facts.load_s},
                         {"simulate", facts.simulate_s},
                         {"broad_phase", totals.times.broad_phase_s},
                         {"detect", totals.times.detect_s},
                         {"cut", totals.times.cut_s},
                         {"measure", facts.measure_s},
                         {"checkpoints", facts.checkpoints_s},
                         {"write", facts.write_s},
                         {"render", facts.render_s},
                         {"total", facts.since_start.seconds()}};
  }
  json["memory_mb"] = {{"peak_process", peak_process_mb()}, {"device", static_cast<double>(facts.device_bytes) / 1e6}};
  for (const auto& input : facts.inputs) {
    json["inputs"].push_back({{"role", input.role}, {"path", recorded_path(input.path)}, {"sha256", input.sha256}});
  }
  json["warnings"] = Json::array();
  for (const std::string& warning : facts.warnings) json["warnings"].push_back(recorded_text(warning));
  write_file(dir + "/summary.json", text_of_summary(json));
}

}  // namespace reamsim
