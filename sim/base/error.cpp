// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/base/error.h"

#include <algorithm>
#include <new>

#include "sim/base/process.h"

namespace reamsim {

namespace {

std::string lines_of(const std::vector<Mistake>& mistakes) {
  std::string out;
  for (const Mistake& mistake : mistakes) out += (out.empty() ? "" : "\n") + mistake.line();
  return out;
}

constexpr std::size_t kMostShown = 50;

bool is_within(std::string_view key, std::string_view above) {
  return key.starts_with(above) && (key.size() == above.size() || key[above.size()] == '.');
}

}  // namespace

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

InputError::InputError(const SourceLocation& where, const std::string& key, const std::string& found,
                       const std::string& expected)
    : InputError(std::vector<Mistake>(1, Mistake{where, key, found, expected})) {}

InputError::InputError(std::vector<Mistake> mistakes)
    : std::runtime_error(lines_of(mistakes)),
      mistakes_(std::make_shared<const std::vector<Mistake>>(std::move(mistakes))) {}

void refuse_file(const std::string& path, const std::string& found, const std::string& expected) {
  throw InputError({path, 0, 0}, "", found, expected);
}

std::string message_of(const std::exception& error) {
  const bool ours = dynamic_cast<const InputError*>(&error) != nullptr ||
                    dynamic_cast<const RunError*>(&error) != nullptr ||
                    dynamic_cast<const Interrupted*>(&error) != nullptr;
  if (ours) return error.what();
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) {
    return "out of memory; " + address_space_note("", ": raise it, or ") +
           "use a larger bone.voxel_mm or a smaller crop";
  }
  return "internal error: please report it with the scenario";
}

void Diagnostics::append(const Diagnostics& from, const std::string& before) {
  for (const std::string& text : from.notes) note(before + text);
  for (const std::string& text : from.warnings) warn(before + text);
  for (const std::string& text : from.listings) list(before + text);
}

bool MistakeList::concerns(std::string_view key) const {
  const auto related = [&](std::string_view other) { return is_within(other, key) || is_within(key, other); };
  return std::ranges::any_of(mistakes_, related, &Mistake::key) || std::ranges::any_of(doubted_, related);
}

bool MistakeList::has_key_in(std::string_view section) const {
  return std::ranges::any_of(mistakes_, [&](const Mistake& mistake) {
    const std::string_view key = mistake.key;
    const std::size_t dot = key.rfind('.');
    return (dot == std::string_view::npos ? std::string_view() : key.substr(0, dot)) == section;
  });
}

void MistakeList::throw_if_any() const {
  if (mistakes_.empty()) return;
  std::vector<Mistake> sorted = mistakes_;
  std::ranges::stable_sort(sorted, {}, [](const Mistake& m) {  // mistakes without a line come last
    return std::make_tuple(m.where.line == 0, m.where.file, m.where.line, m.where.column);
  });
  if (sorted.size() > kMostShown) {
    const std::string rest = "and " + std::to_string(sorted.size() - kMostShown) + " mistakes more";
    sorted.resize(kMostShown);
    sorted.push_back({.where = {}, .key = "", .found = rest, .expected = ""});
  }
  throw InputError(std::move(sorted));
}

}  // namespace reamsim
