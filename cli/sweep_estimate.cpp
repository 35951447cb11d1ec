// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/sweep_estimate.h"

#include <fmt/core.h>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "sim/base/error.h"
#include "sim/base/stopwatch.h"
#include "sim/run/cost_estimate.h"
#include "sim/run/simulation.h"
#include "sim/scenario/passes.h"
#include "sim/scene/clearance.h"
#include "sim/scene/contact_forecast.h"

namespace reamsim {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kEstimateTiming_s = 0.1;

}  // namespace

std::string RunEstimate::text() const {
  const std::string texts = Json(warnings).dump(-1, ' ', false, Json::error_handler_t::replace);
  return fmt::format("{} {} {} {} {}", load_s, simulate_s, memory_bytes, frames, texts);
}

RunEstimate RunEstimate::parse(const std::string& text) {
  RunEstimate out;
  std::istringstream in(text);
  std::string warnings;
  in >> out.load_s >> out.simulate_s >> out.memory_bytes >> out.frames;
  std::getline(in, warnings);
  const Json json = Json::parse(warnings, nullptr, false);
  if (!in || !json.is_array()) throw RunError("a worker gave no estimate: " + text);
  for (const Json& warning : json) out.warnings.push_back(warning.is_string() ? warning.get<std::string>() : "");
  return out;
}

RunEstimate RunEstimator::estimate(const Scenario& scenario, RunResources& resources) {
  const Stopwatch watch;
  Diagnostics report;
  MistakeList mistakes;
  SimulationInput scene = load_scene(scenario, report, mistakes, resources.bones);
  mistakes.throw_if_any();
  RunEstimate out{.load_s = watch.seconds(), .frames = scene.last_frame(), .warnings = {}};
  const std::vector<ContactForecast> contacts = forecast_passes(scene);
  warn_of_contact(scene, contacts, report);
  if (const auto clearance = find_clearance(scene)) warn_of_clearance(*clearance, scene, report);
  out.warnings = report.warnings;
  do {
    out.memory_bytes = std::max(out.memory_bytes, plan_memory(scene).process_bytes);
    out.simulate_s += simulate_s(scene, resources);
  } while (begin_next_pass(scene));
  return out;
}

double RunEstimator::simulate_s(SimulationInput& scene, RunResources& resources) {
  const auto frames = static_cast<double>(scene.motion.last_frame() - scene.motion.first_frame + 1);
  const std::vector<PassSpec> passes = passes_of(scene.scenario);
  const std::tuple key{resources.bones->loaded(), passes[static_cast<std::size_t>(scene.motion.pass) - 1].tool.mesh,
                       scene.scenario.output.force_basis};
  const auto known = s_per_frame_.find(key);
  if (known != s_per_frame_.end()) return known->second * frames;
  const auto engine = load_engine(scene, resources.devices);  // also finds what does not fit the device
  const double seconds = plan_time(scene, *engine, kEstimateTiming_s).simulate_s;
  s_per_frame_[key] = seconds / std::max(1.0, frames);
  return seconds;
}

}  // namespace reamsim
