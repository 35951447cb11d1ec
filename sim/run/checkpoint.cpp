// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/run/checkpoint.h"

#include <algorithm>

#include "sim/base/error.h"

namespace reamsim {

namespace {

constexpr const char* kStartAgain = "start again with --overwrite, or restore what has changed";

/// Lines of a text.
std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    out.push_back(text.substr(at, end - at));
    at = end + 1;
  }
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

/// How often checkpoints are written does not change results.
bool may_differ(const std::string& line) {
  return line.find("checkpoint_s:") != std::string::npos;
}

void require_same_scenario(const std::string& saved, const std::string& current, const std::string& dir) {
  const std::vector<std::string> was = lines_of(saved), is = lines_of(current);
  for (std::size_t i = 0; i < std::max(was.size(), is.size()); ++i) {
    const bool both = i < was.size() && i < is.size();
    if (both && (was[i] == is[i] || (may_differ(was[i]) && may_differ(is[i])))) continue;
    const bool in_new = i < is.size();
    const std::string old_line = i < was.size() ? was[i].substr(indent_of(was[i])) : "nothing";
    throw InputError({dir, 0, 0}, key_at(in_new ? is : was, i),
                     "has changed since the checkpoint, which has \"" + old_line + "\"", kStartAgain);
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
  const auto inside = [dims = fill.brick_dims()](const Vec3i& coord) {
    return (coord.array() >= 0).all() && (coord.array() < dims.array()).all();
  };
  for (const auto& [coord, brick] : checkpoint.fill) {
    if (!inside(coord)) throw InputError({dir, 0, 0}, "checkpoint", "does not fit the bone", kStartAgain);
    fill.put(coord, brick);
  }
  fill.take_changed();
  for (const Vec3i& coord : checkpoint.changed) {
    if (!inside(coord)) throw InputError({dir, 0, 0}, "checkpoint", "does not fit the bone", kStartAgain);
    fill.mark_changed(coord);
  }
}

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

}  // namespace reamsim
