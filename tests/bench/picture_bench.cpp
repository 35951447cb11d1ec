// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// How long pictures of 1920 x 1080 take, each with its labels: of the states along a run, for a film and as pictures
// (the bone changes, is meshed where it changed, and drawn), of the last state, supersampled, and written as PNG.
//
//   picture_bench [RESULTS] [--benchmark_filter=...]
//
// RESULTS is the folder of a run that has pictures; without it a glenoid on 512³ voxels is reamed first, by formula.
#include <benchmark/benchmark.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "sim/base/error.h"
#include "tests/render/opened_run.h"
#include "tests/render/results_fixture.h"
#include "tests/support/temp_dir.h"

namespace reamsim {
namespace {

constexpr int kSide = 512;
constexpr double kFixtureSide_mm = 46;

RenderSettings settings_with(int supersampling) {
  RenderSettings settings;
  settings.supersampling = supersampling;
  return settings;
}

using test::OpenedRun;

PixelImage picture(OpenedRun& run, const Camera& camera, const ForceRow& row, bool filtered = false) {
  const std::optional<PlacedTool> tool = run.view.tool_at(row.frame);
  PixelImage image = run.renderer.render(camera, tool, filtered);
  Labels labels = run.view.labels(camera, tool);
  labels.force = run.captions.arrow(row);
  return annotated_picture(std::move(image), run.view.page(), camera, labels, Background::studio);
}

/// From the results on disk to the first picture.
void opening(benchmark::State& state, const std::string& dir) {
  while (state.KeepRunning()) {
    OpenedRun run(dir, settings_with(1));
    benchmark::DoNotOptimize(run.renderer.render(run.camera("oblique"), std::nullopt));
  }
}

void frame_of_a_run(benchmark::State& state, const std::string& dir, bool filtered) {
  const RenderSettings settings = settings_with(1);
  auto run = std::make_unique<OpenedRun>(dir, settings);
  const Camera camera = run->camera("oblique");
  const std::vector<std::int64_t> frames = run->view.frames();
  std::size_t next = 1;
  while (state.KeepRunning()) {
    if (next == frames.size()) {
      state.PauseTiming();
      run.reset();
      run = std::make_unique<OpenedRun>(dir, settings);
      next = 1;
      state.ResumeTiming();
    }
    run->renderer.advance_to(frames[next]);
    benchmark::DoNotOptimize(picture(*run, camera, run->run.log().at(frames[next], dir), filtered));
    ++next;
  }
}

void last_state(benchmark::State& state, const std::string& dir, const std::string& camera_name, int supersampling,
                bool filtered = false) {
  OpenedRun run(dir, settings_with(supersampling));
  run.renderer.advance_to_last();
  const Camera camera = run.camera(camera_name);
  while (state.KeepRunning()) benchmark::DoNotOptimize(picture(run, camera, run.last_row(), filtered));
}

void written(benchmark::State& state, const std::string& dir, const std::string& to) {
  OpenedRun run(dir, settings_with(1));
  run.renderer.advance_to_last();
  PixelImage image = picture(run, run.camera("oblique"), run.last_row());
  while (state.KeepRunning()) write_png(to + "/picture.png", image);
}

void register_all(const std::string& dir, const std::string& scratch) {
  const auto add = [](const char* name, auto run) {
    benchmark::RegisterBenchmark(name, run)->Unit(benchmark::kMillisecond)->UseRealTime();
  };
  add("opening", [dir](benchmark::State& s) { opening(s, dir); });
  add("frame_of_a_film", [dir](benchmark::State& s) { frame_of_a_run(s, dir, true); });
  add("picture_of_a_run", [dir](benchmark::State& s) { frame_of_a_run(s, dir, false); });
  add("oblique_filtered", [dir](benchmark::State& s) { last_state(s, dir, "oblique", 1, true); });
  add("oblique", [dir](benchmark::State& s) { last_state(s, dir, "oblique", 1); });
  add("section", [dir](benchmark::State& s) { last_state(s, dir, "section", 1); });
  add("oblique_supersampled_2", [dir](benchmark::State& s) { last_state(s, dir, "oblique", 2); });
  add("oblique_supersampled_4", [dir](benchmark::State& s) { last_state(s, dir, "oblique", 4); });
  add("png", [dir, scratch](benchmark::State& s) { written(s, dir, scratch); });
}

int main_of(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  const test::TempDir scratch;
  std::string dir = argc > 1 ? argv[1] : "";
  if (dir.empty()) {
    dir = scratch.path();
    FixtureOptions options;
    options.voxel_mm = kFixtureSide_mm / kSide;
    options.every = 5;
    write_results(dir, options);
  }
  register_all(dir, scratch.path());
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}

}  // namespace
}  // namespace reamsim

int main(int argc, char** argv) {
  try {
    return reamsim::main_of(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "picture_bench: %s\n", error.what());
    return 1;
  }
}
