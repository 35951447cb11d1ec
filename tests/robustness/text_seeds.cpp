// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Seeds of what reamsim itself parses: scenarios, recorded poses, results folders and checkpoints.
#include <zlib.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "render/plots/plots.h"
#include "seeds.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/record/force_log.h"
#include "sim/record/output_folder.h"
#include "sim/run/checkpoint.h"
#include "sim/scenario/parse.h"
#include "sim/tool/motion.h"
#include "tests/cli/subprocess.h"

namespace reamsim::test {

namespace {

namespace fs = std::filesystem;

const std::string kScenario =
    "version: 2\nbone:\n  source: phantom\n  voxel_mm: 0.5\n  phantom: {shape: half_space, size_mm: [8, 8, 5]}\n"
    "tool: {mesh: " REAMSIM_ROOT
    "/assets/reamer_flat.stl}\nmotion:\n  frame_rate_hz: 20\n"
    "  plunge: {approach_mm: 0.5, feed_mm_s: 5, depth_mm: 1, dwell_s: 0, retract_mm: 2, retract_mm_s: 20}\n"
    "render:\n  width_px: 64\n  height_px: 64\n  every_frames: 1000\n  cameras: [oblique]\n"
    "  user_cameras: [{name: side, position_mm: [100, 0, 20], target_mm: [0, 0, 0]}]\n"
    "engine: {device: serial, batch_frames: 4}\n"
    "output: {checkpoint_s: 0.0001}\n";

/// Runs `reamsim` on a file or folder. Throws what an error of the program stands for; a signal that ended the program
/// ends this process.
void run_reamsim(const std::vector<std::string>& arguments, std::map<std::string, std::string> environment = {}) {
  const ProgramResult result =
      run_program(REAMSIM_PROGRAM,
                  {.arguments = arguments, .environment = std::move(environment), .folder = "", .interrupt_when = {}});
  if (result.signal != 0) raise(result.signal);
  std::string error;
  for (std::size_t at = 0; at < result.err.size();) {
    const std::size_t end = std::min(result.err.find('\n', at), result.err.size());
    const std::string line = result.err.substr(at, end - at);
    if (!line.starts_with("reamsim: warning: ")) error += (error.empty() ? "" : " | ") + line;
    at = end + 1;
  }
  if (result.status == 2) throw InputError(error);
  if (result.status != 0) throw RunError(error);
}

std::string text_of(const std::string& path) {
  return read_file(path, "a file of the tests");
}

class TextSeeds {
 public:
  explicit TextSeeds(std::string root) : root_(std::move(root)) {}

  std::vector<Seed> make() {
    add_scenarios();
    add_poses();
    add_results();
    add_checkpoints();
    return std::move(seeds_);
  }

 private:
  /// `named`: what a message names; "" = the damaged file.
  Seed& add(const std::string& reader, std::vector<std::string> files, const std::string& named) {
    Seed& seed = seeds_.emplace_back();
    seed.reader = reader;
    seed.folder = root_ + "/" + std::to_string(seeds_.size());
    seed.files = std::move(files);
    seed.named = named;
    seed.text = true;
    fs::create_directories(seed.folder);
    return seed;
  }

  void add_scenarios() {
    Seed& small = add("scenario, check", {"small.yaml"}, "");
    const std::string path = small.folder + "/small.yaml";
    write_file(path, kScenario);
    small.read = [path](const std::string&) { run_reamsim({"check", path}); };
    Seed& all = add("scenario", {}, "");
    for (const auto& entry : fs::directory_iterator(REAMSIM_ROOT "/trajectories")) {
      const std::string name = entry.path().filename().string();
      if (!entry.is_regular_file()) continue;                              // studies/
      if (name.starts_with("ct_") || name.starts_with("mesh_")) continue;  // their data may be absent
      std::string text = text_of(entry.path().string());
      for (std::size_t at; (at = text.find("../assets")) != std::string::npos;) {
        text.replace(at, 9, REAMSIM_ROOT "/assets");
      }
      write_file(all.folder + "/" + name, text);
      all.files.push_back(name);
    }
    std::ranges::sort(all.files);
    all.read = [](const std::string& file) { parse_scenario(file, {}); };
  }

  void add_poses() {
    Seed& seed = add("recorded poses", {"poses.csv"}, "");
    std::string text = "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,spin_rpm\n";
    for (int i = 0; i < 20; ++i)
      text += std::to_string(0.01 * i) + ",0,0.5," + std::to_string(1 - 0.1 * i) + ",1,0,0,0,250\n";
    write_file(seed.folder + "/poses.csv", text);
    seed.read = [](const std::string& file) {
      MotionSettings motion;
      motion.csv = CsvMotionSettings{.path = file, .spin_rpm = 250};
      Diagnostics report;
      const Motion built = build_motion(motion, std::nullopt, report);
      for (std::size_t k = 0; k < built.poses.size(); k += 1 + built.poses.size() / 1000) built.poses[k];
    };
  }

  void add_results() {
    Seed& render = add("results, render",
                       {"out/forces.csv", "out/scenario.yaml", "out/summary.json", "out/snapshots/tool.stl",
                        "out/snapshots/000000.vdb", "out/reamed.vdb", "out/manifest.json"},
                       "out");
    const std::string out = render.folder + "/out", copy = render.folder + "/copy/out";
    write_file(render.folder + "/s.yaml", kScenario);
    run_reamsim({"run", render.folder + "/s.yaml", "-o", out, "--quiet"});
    render.read = [out, copy](const std::string&) {
      fs::remove_all(copy);
      fs::create_directories(fs::path(copy).parent_path());
      fs::copy(out, copy, fs::copy_options::recursive);
      run_reamsim({"render", copy, "--only", "pictures", "--only", "report"});
    };
    Seed& compare = add("results, compare", {"a/summary.json", "a/forces.csv", "a/scenario.yaml"}, "");
    const std::string folder = compare.folder;
    for (const char* name : {"/a", "/b"}) fs::copy(out, folder + name, fs::copy_options::recursive);
    compare.read = [folder](const std::string&) {
      compare_summaries({{folder + "/a", "a"}, {folder + "/b", "b"}});
      read_force_log(folder + "/a/forces.csv", {.mean_travel_mm = 0.5});
      parse_result_settings(folder + "/a/scenario.yaml");
    };
    Seed& replace = add("results, --overwrite", {"a/manifest.json"}, "/a");
    fs::copy(out, replace.folder + "/a", fs::copy_options::recursive);
    replace.read = [dir = replace.folder + "/a"](const std::string&) {
      OutputFolder({.dir = dir, .kind = ResultKind::run, .overwrite = true, .inputs = {}});
    };
  }

  /// A run whose disk was full when reamed.vdb was written.
  void add_checkpoints() {
#ifdef REAMSIM_FAULTS  // not with sanitizers
    Seed& seed = add("checkpoint, resume", {}, "out.partial");
    const std::string yaml = seed.folder + "/s.yaml", out = seed.folder + "/out", copy = seed.folder + "/copy";
    std::string text = kScenario;
    write_file(yaml, text.insert(text.find("  width_px"), "  enabled: false\n"));
    try {
      run_reamsim({"run", yaml, "-o", out, "--quiet"}, {{"LD_PRELOAD", REAMSIM_FAULTS},
                                                        {"REAMSIM_FAULT", "write"},
                                                        {"REAMSIM_FAULT_AT", "1"},
                                                        {"REAMSIM_FAULT_DIR", out + ".partial/reamed.vdb"}});
    } catch (const RunError&) {  // this one
    }
    for (const char* name : {"checkpoint-0.bin", "checkpoint-1.bin", "forces.csv", "timings.csv"}) {
      seed.files.push_back(std::string("out.partial/") + name);
    }
    seed.read = [yaml, out, copy](const std::string&) {
      fs::remove_all(copy);
      fs::create_directories(copy);
      fs::copy(out + ".partial", copy + "/out.partial", fs::copy_options::recursive);
      run_reamsim({"run", yaml, "-o", copy + "/out", "--resume", "--quiet"});
    };
    seed.repair = with_checkpoint_sum;
#endif
  }

  /// A damaged checkpoint with the CRC-32 of a whole one, so that the damage reaches its reader.
  [[maybe_unused]] static std::string with_checkpoint_sum(const std::string& name, std::string bytes) {
    if (!name.ends_with(".bin") || bytes.size() < sizeof(std::uint32_t)) return bytes;
    const std::size_t body = bytes.size() - sizeof(std::uint32_t);
    const auto sum = static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), body));
    std::memcpy(bytes.data() + body, &sum, sizeof sum);
    return bytes;
  }

  std::string root_;
  std::vector<Seed> seeds_;
};

}  // namespace

std::vector<Seed> write_text_seeds(const std::string& folder) {
  return TextSeeds(folder).make();
}

}  // namespace reamsim::test
