// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The format of a checkpoint: that of value_file.h.

#include "sim/run/checkpoint.h"

#include <fmt/core.h>
#include <algorithm>
#include <filesystem>

#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/base/value_file.h"
#include "sim/scenario/parse.h"

namespace reamsim {

namespace {

constexpr const char* kStartAgain = "start again with --overwrite, or restore what has changed";

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> out = split(text, '\n');
  if (out.back().empty()) out.pop_back();
  return out;
}

std::size_t indent_of(const std::string& line) {
  return std::min(line.find_first_not_of(' '), line.size());
}

/// The path of the key in a line of block style YAML: the keys of the less indented lines above it, and its own.
std::string key_at(const std::vector<std::string>& lines, std::size_t at) {
  std::string key;
  std::size_t indent = std::string::npos;
  for (std::size_t i = at + 1; i-- > 0;) {
    if (indent_of(lines[i]) >= indent) continue;
    indent = indent_of(lines[i]);
    const std::string name = lines[i].substr(indent, lines[i].find(':', indent) - indent);
    if (!name.starts_with("- ")) key = key.empty() ? name : name + "." + key;
  }
  return key;
}

void require_same_scenario(const std::string& saved, const std::string& current, const std::string& dir) {
  const std::vector<std::string> was = lines_of(saved), is = lines_of(current);
  // How often checkpoints are written does not change results; use_device() warns of another device.
  const auto may_differ = [](const std::string& line) {
    return line.find("checkpoint_s:") != std::string::npos || line.starts_with("  device: ");
  };
  for (std::size_t i = 0; i < std::max(was.size(), is.size()); ++i) {
    const bool both = i < was.size() && i < is.size();
    if (both && (was[i] == is[i] || (may_differ(was[i]) && may_differ(is[i])))) continue;
    const bool in_new = i < is.size();
    const std::string old_line = i < was.size() ? was[i].substr(indent_of(was[i])) : "nothing";
    throw InputError({dir, 0, 0}, key_at(in_new ? is : was, i),
                     "has changed since the checkpoint, which has \"" + old_line + "\"", kStartAgain);
  }
}

/// Throws InputError, with the key or input that differs, where `saved` belongs to another run. The device may differ.
void require_same_run(const RunIdentity& saved, const RunIdentity& current, const std::string& dir) {
  if (saved.program != current.program) {
    throw InputError({dir, 0, 0}, "checkpoint", "written by " + saved.program,
                     "use that version, or start again with --overwrite");
  }
  require_same_scenario(saved.scenario, current.scenario, dir);
  for (std::size_t i = 0; i < current.inputs.size(); ++i) {
    const InputSum& input = current.inputs[i];
    if (i < saved.inputs.size() && saved.inputs[i].role == input.role && saved.inputs[i].sha256 == input.sha256)
      continue;
    throw InputError({dir, 0, 0}, input.role, input.path + " has changed since the checkpoint", kStartAgain);
  }
}

constexpr std::string_view kMagic = "reamsim checkpoint 5\n";

std::optional<Checkpoint> read_checkpoint(const std::string& path) {
  const std::optional<std::string> text = read_whole_file(path);
  if (!text) return std::nullopt;
  try {
    return ValueReader(values_of(*text, kMagic)).take<Checkpoint>();
  } catch (const DamagedValues&) {
    return std::nullopt;
  }
}

}  // namespace

std::vector<PlacedBrick> reamed_bricks(const FillBricks& before, const FillBricks& now) {
  std::vector<PlacedBrick> out;
  now.for_each_brick([&](const Vec3i& coord, const FillBricks::Brick& brick) {
    const FillBricks::Brick* old = before.brick(coord);
    if (old != &brick && (old == nullptr || *old != brick)) out.emplace_back(coord, brick);
  });
  return out;
}

void restore_fill(const Checkpoint& checkpoint, FillBricks& fill, const std::string& dir) {
  const auto checked = [&](const Vec3i& coord) -> const Vec3i& {
    if (fill.lattice().contains(coord)) return coord;
    throw InputError({dir, 0, 0}, "checkpoint", "does not fit the bone", kStartAgain);
  };
  for (const auto& [coord, brick] : checkpoint.fill) fill.put(checked(coord), brick);
  fill.take_changed();
  for (const Vec3i& coord : checkpoint.changed) fill.mark_changed(checked(coord));
}

std::optional<Checkpoint> CheckpointFiles::read() {
  std::optional<Checkpoint> first = read_checkpoint(path(0)), second = read_checkpoint(path(1));
  const bool take_first = first && (!second || first->simulation.frame >= second->simulation.frame);
  next_ = take_first ? 1 : 0;
  return take_first ? std::move(first) : std::move(second);
}

std::size_t CheckpointFiles::write(const Checkpoint& checkpoint) {
  ValueWriter writer(kMagic);
  writer(checkpoint);
  const std::string& text = writer.finish();
  replace_file(path(next_), text);
  next_ = 1 - next_;
  return text.size();
}

void CheckpointFiles::remove(Diagnostics& report) const {
  for (const int number : {0, 1}) {
    std::error_code error;
    std::filesystem::remove(path(number), error);
    if (error) report.warn(path(number) + ": cannot be removed (" + error.message() + "); the results do not need it");
  }
}

RunCheckpoints::RunCheckpoints(const std::string& dir, double every_s, bool resume)
    : dir_(dir), every_s_(every_s), files_(dir) {
  if (resume) last_ = files_.read();
  if (last_) saved_frame_ = last_->simulation.frame;
}

void RunCheckpoints::identify(const Scenario& scenario, const std::vector<InputSum>& inputs) {
  identity_ = {.program = "reamsim " REAMSIM_VERSION, .device = "", .scenario = to_yaml(scenario), .inputs = {}};
  for (const InputSum& input : inputs) {
    if (input.path != scenario.file) identity_.inputs.push_back(input);
  }
  if (last_) require_same_run(last_->identity, identity_, dir_);
}

void RunCheckpoints::use_device(const std::string& device, Diagnostics& report) {
  identity_.device = device;
  if (last_ && last_->identity.device != device) {
    report.warn("continued on " + device + "; the run began on " + last_->identity.device);
  }
}

void RunCheckpoints::restore(FillBricks& fill) {
  if (!last_) return;
  restore_fill(*last_, fill, dir_);
  last_->fill.clear();
}

Recorder RunCheckpoints::open_logs(double voxel_mm, const Scenario& scenario, Diagnostics& report) {
  const PoseFeedback feedback{.push = scenario.motion.push.has_value(),
                              .springs = scenario.motion.compliance.has_value()};
  if (!last_) return {dir_, voxel_mm, scenario.output.force_basis, feedback};
  for (const std::string& warning : last_->warnings) report.warn(warning);
  // Left by an attempt that was killed after its simulation: with it, and rows behind the checkpoint removed, the
  // folder would look like that of a finished run.
  std::error_code ignored;
  std::filesystem::remove(dir_ + "/reamed.vdb", ignored);
  return {dir_,
          voxel_mm,
          scenario.output.force_basis,
          feedback,
          last_->logs,
          last_->simulation.frame,
          std::move(last_->removed)};
}

bool RunCheckpoints::save(const SimulationState& state, Recorder& recorder, const BoneView& bone,
                          const Diagnostics& report) {
  if (every_s_ <= 0 || saved_frame_ == state.frame) return false;
  const Stopwatch watch;
  const std::size_t bytes = files_.write({.identity = identity_,
                                          .simulation = state,
                                          .logs = recorder.sync(),
                                          .warnings = report.warnings,
                                          .removed = recorder.removed_frames(),
                                          .fill = reamed_bricks(bone.fill_before, bone.fill),
                                          .changed = bone.fill.changed()});
  saved_frame_ = state.frame;
  since_last_ = Stopwatch();
  ++written_;
  seconds_ += watch.seconds();
  largest_bytes_ = std::max(largest_bytes_, bytes);
  return true;
}

std::string RunCheckpoints::cost() const {
  if (written_ == 0) return "no checkpoint was due";
  return fmt::format("checkpoints written: {}, {:.3f} s in all, the largest {:.2f} MB", written_, seconds_,
                     static_cast<double>(largest_bytes_) / 1e6);
}

}  // namespace reamsim
