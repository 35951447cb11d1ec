// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/bench_latency.h"

#include <fmt/core.h>

#include "cli/commands.h"
#include "cli/environment.h"
#include "cli/stop.h"
#include "sim/base/error.h"
#include "sim/bench/latency.h"
#include "sim/scenario/parse.h"

namespace reamsim {

namespace {

constexpr std::int64_t kMostFrames = 5000;

}  // namespace

void bench_latency(const std::vector<std::string>& scenarios, const std::string& device, const Console& console) {
  const auto kernels = prepare_opencl(device, console);
  std::vector<std::string> overrides;
  if (device != "auto") overrides.push_back("engine.device=" + device);
  for (const std::string& file : scenarios) {
    Diagnostics report;
    const PrintOnError warnings_of_error(report, console);
    const Scenario scenario = parse_scenario(file, overrides);
    SimulationInput scene = load_scene(scenario, report);
    const auto engine = load_engine(scene);
    const bench::Latency found = bench::frame_latency(scene, *engine, kMostFrames, stop_requested);
    if (found.frames == 0)
      throw InputError(
          {file, 0, 0}, "motion",
          fmt::format("no more than {} frames are in contact, which the measurement leaves out", bench::kWarmUpFrames),
          "a motion that reams for longer");
    console.say(
        fmt::format("{}, {:g} mm, {} on {}: {} frames in contact, median {:.3f} ms, 99 % {:.3f} ms, 99.9 % {:.3f} ms, "
                    "most {:.3f} ms",
                    scenario.name, scene.bone.voxmap->grid.voxel_mm, name_of(engine_of(scene.scenario)),
                    engine->device(), found.frames, found.median_ms, found.p99_ms, found.p999_ms, found.most_ms));
  }
}

}  // namespace reamsim
