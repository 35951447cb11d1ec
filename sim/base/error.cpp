// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/base/error.h"

#include <new>
#include <utility>

#include "sim/base/memory.h"

namespace reamsim {

std::string SourceLocation::text() const {
  std::string out = file;
  if (line > 0) out += ":" + std::to_string(line);
  if (line > 0 && column > 0) out += ":" + std::to_string(column);
  return out;
}

std::string Mistake::line() const {
  std::string out = where.text();
  if (!key.empty()) out += (out.empty() ? "" : ": ") + key;
  if (!found.empty()) out += (out.empty() ? "" : ": ") + found;
  if (!expected.empty()) out += "; " + expected;
  return out;
}

namespace {

std::string lines_of(const std::vector<Mistake>& mistakes) {
  std::string out;
  for (const Mistake& mistake : mistakes) out += (out.empty() ? "" : "\n") + mistake.line();
  return out;
}

}  // namespace

InputError::InputError(const SourceLocation& where, const std::string& key, const std::string& found,
                       const std::string& expected)
    : InputError(std::vector<Mistake>(1, Mistake{where, key, found, expected})) {}

InputError::InputError(std::vector<Mistake> mistakes)
    : std::runtime_error(lines_of(mistakes)),
      mistakes_(std::make_shared<const std::vector<Mistake>>(std::move(mistakes))) {}

std::string message_of(const std::exception& error) {
  const bool ours = dynamic_cast<const InputError*>(&error) != nullptr ||
                    dynamic_cast<const RunError*>(&error) != nullptr ||
                    dynamic_cast<const Interrupted*>(&error) != nullptr;
  if (ours) return error.what();
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) {
    const std::string limit = address_space_note();
    return "out of memory; " + (limit.empty() ? "" : limit + ": raise it, or ") +
           "use a larger bone.voxel_mm or a smaller crop";
  }
  return "internal error: please report it with the scenario";
}

}  // namespace reamsim
