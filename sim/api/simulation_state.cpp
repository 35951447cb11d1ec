// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// States of a simulation, in memory and in files.
#include <filesystem>

#include "sim/api/state_parts.h"
#include "sim/base/file.h"
#include "sim/base/value_file.h"
#include "sim/run/run_scenario.h"
#include "sim/scenario/parse.h"

namespace reamsim {

namespace {

constexpr std::string_view kMagic = "reamsim state 1\n";
/// What the formats of all versions begin with.
constexpr std::string_view kAnyMagic = "reamsim state ";

std::vector<PlacedBrick> changed_bricks(const Simulation::State::Parts& parts) {
  if (const auto* bricks = std::get_if<std::vector<PlacedBrick>>(&parts.fill)) return *bricks;
  return reamed_bricks(parts.before, std::get<FillBricks>(parts.fill));
}

Simulation::State::Parts read_values(std::string_view text) {
  ValueReader reader(values_of(text, kMagic));
  Simulation::State::Parts out;
  reader(out.bone);
  reader(out.progress);
  reader(out.fill.emplace<std::vector<PlacedBrick>>());
  return out;
}

class CallerMonitor final : public RunMonitor {
 public:
  explicit CallerMonitor(const RunOptions& options) : options_(options) {}

  void take(const Diagnostics& report) override {
    warnings.insert(warnings.end(), report.warnings.begin(), report.warnings.end());
  }
  void progress(std::int64_t done, std::int64_t total) override {
    if (options_.progress) options_.progress(done, total);
  }
  [[nodiscard]] bool stop_requested() override { return options_.stop && options_.stop(); }

  std::vector<std::string> warnings;

 private:
  const RunOptions& options_;
};

}  // namespace

BoneIdentity identity_of(const Bone& bone) {
  BoneIdentity out{.grid = bone.voxmap->grid};
  const auto add = [&out](const Vec3i& coord, const auto& brick) {
    const auto bytes_of = [](const auto& value) {
      return std::string_view(reinterpret_cast<const char*>(&value), sizeof value);
    };
    const std::array<int, 3> place{coord.x(), coord.y(), coord.z()};
    out.crc = crc_of(bytes_of(brick), crc_of(bytes_of(place), out.crc));
  };
  bone.voxmap->grade.for_each_brick(add);
  bone.fill.for_each_brick(add);
  return out;
}

FillBricks Simulation::State::Parts::fill_on(const FillBricks& start) const {
  if (const auto* copy = std::get_if<FillBricks>(&fill)) return *copy;
  FillBricks out = start;
  for (const auto& [coord, brick] : std::get<std::vector<PlacedBrick>>(fill)) {
    if (!out.lattice().contains(coord)) throw InputError("the state does not fit its bone: it is damaged");
    out.put(coord, brick);
  }
  return out;
}

void Simulation::State::save(const std::string& path) const {
  guarded([&] {
    ValueWriter writer(kMagic);
    writer(parts_->bone);
    writer(parts_->progress);
    writer.put(changed_bricks(*parts_));
    replace_file(path, writer.finish());
  });
}

Simulation::State Simulation::State::load(const std::string& path) {
  return guarded([&] {
    const auto wrong = [&path](const std::string& found) {
      return InputError({path, 0, 0}, "", found, "expected a state that save() wrote");
    };
    const std::optional<std::string> text = read_whole_file(path);
    if (!text) throw wrong(std::filesystem::exists(path) ? "cannot be read" : "no such file");
    if (!text->starts_with(kAnyMagic)) throw wrong("is no state of a simulation");
    if (!text->starts_with(kMagic)) throw wrong("is a state of another version of reamsim");
    try {
      return State(std::make_shared<Parts>(read_values(*text)));
    } catch (const DamagedValues&) {
      throw wrong("is damaged: its checksum or length does not fit");
    }
  });
}

RunResults run_scenario(const std::string& scenario, const RunOptions& options) {
  return guarded([&]() -> RunResults {
    RunRequest request;
    request.scenario = parse_scenario(scenario, options.set);
    request.dir = options.dir.empty() ? results_dir(request.scenario) : options.dir;
    request.overwrite = options.overwrite;
    request.resume = options.resume;
    RunResources resources;
    CallerMonitor monitor(options);
    try {
      run_scenario(request, resources, monitor, nullptr);
    } catch (const Interrupted& interrupted) {
      throw Stopped(interrupted.what());
    }
    return {request.dir, std::move(monitor.warnings)};
  });
}

}  // namespace reamsim
