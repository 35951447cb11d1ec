// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The format of a checkpoint: that of value_file.h.
#include <filesystem>

#include "sim/base/file.h"
#include "sim/run/checkpoint.h"
#include "sim/run/value_file.h"

namespace reamsim {

namespace {

constexpr std::string_view kMagic = "reamsim checkpoint 4\n";

/// Calls visit() for every value of a checkpoint, in the order of the file.
template <class Visit, class State>
void visit_values(Visit& visit, State& c) {
  visit(c.identity.program);
  visit(c.identity.device);
  visit(c.identity.scenario);
  visit(c.identity.inputs);
  visit(c.simulation.frame);
  visit(c.simulation.energy.work_mj);
  visit(c.simulation.energy.floor_mj);
  visit(c.simulation.energy.cut_mj);
  visit(c.simulation.energy.first_contact_mm);
  visit(c.simulation.touched);
  visit(c.simulation.warned_of_no_spin);
  visit(c.simulation.feed);
  visit(c.simulation.springs);
  visit(c.logs.forces_bytes);
  visit(c.logs.timings_bytes);
  visit(c.logs.basis_bytes);
  visit(c.warnings);
  visit(c.removed);
  visit(c.fill);
  visit(c.changed);
}

std::optional<Checkpoint> read_checkpoint(const std::string& path) {
  const std::optional<std::string> text = read_whole_file(path);
  if (!text) return std::nullopt;
  try {
    ValueReader reader(values_of(*text, kMagic));
    Checkpoint out;
    visit_values(reader, out);
    return out;
  } catch (const DamagedValues&) {
    return std::nullopt;
  }
}

}  // namespace

std::string CheckpointFiles::path(int number) const {
  return dir_ + "/checkpoint-" + std::to_string(number) + ".bin";
}

std::optional<Checkpoint> CheckpointFiles::read() {
  std::optional<Checkpoint> first = read_checkpoint(path(0)), second = read_checkpoint(path(1));
  const bool take_first = first && (!second || first->simulation.frame >= second->simulation.frame);
  next_ = take_first ? 1 : 0;
  return take_first ? std::move(first) : std::move(second);
}

std::size_t CheckpointFiles::write(const Checkpoint& checkpoint) {
  ValueWriter writer(kMagic);
  visit_values(writer, checkpoint);
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

}  // namespace reamsim
