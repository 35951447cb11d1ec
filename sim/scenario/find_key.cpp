// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/key_tree.h"

#include <algorithm>
#include <array>
#include <functional>
#include <numeric>
#include <optional>
#include <ranges>

#include "sim/base/text.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

constexpr std::size_t kLongestKey = 60;  // beyond it no key is meant, and edit distances get slow

/// Parts that unit suffixes are made of, ours and those that people write by mistake.
constexpr std::array<std::string_view, 44> kUnitWords{
    "mm",  "cm", "m",   "um",  "nm",     "km",      "in",     "inch", "s",      "ms",      "us",
    "min", "h",  "sec", "rad", "deg",    "degrees", "rpm",    "rps",  "hz",     "khz",     "mhz",
    "n",   "kn", "mn",  "nmm", "newton", "hu",      "gray",   "g",    "kg",     "mg",      "cm3",
    "mm3", "m3", "j",   "mj",  "kj",     "px",      "pixels", "per",  "voxels", "seconds", "mpa"};

std::string display(const KeyNode& key) {
  const std::string_view unit = unit_of(key.info.name);
  return std::string(key.info.name) + (unit.empty() ? "" : " (" + std::string(unit) + ")");
}

/// Whether all parts of `suffix` ("_mm_min") are words of units.
bool is_unit_suffix(std::string_view suffix) {
  while (!suffix.empty()) {
    if (suffix[0] != '_') return false;
    suffix.remove_prefix(1);
    const std::string_view word = suffix.substr(0, suffix.find('_'));
    if (std::ranges::find(kUnitWords, word) == kUnitWords.end()) return false;
    suffix.remove_prefix(word.size());
  }
  return true;
}

/// Same name, other unit or none: "feed_mm_min" and "feed" for "feed_mm_s".
bool differs_in_unit_only(const KeyNode& key, std::string_view unknown) {
  const std::string_view stem = without_unit(key.info.name);
  return stem.size() < key.info.name.size() && unknown.starts_with(stem) && is_unit_suffix(unknown.substr(stem.size()));
}

/// Levenshtein's edit distance, without regard to case.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (lower(a[i - 1]) == lower(b[j - 1]) ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

/// The element of `all` whose name is most like `unknown`, or nullptr where none is alike.
template <class Range, class Name>
auto* nearest(const Range& all, std::string_view unknown, const Name& name) {
  const std::ranges::range_value_t<Range>* best = nullptr;
  std::size_t least = std::max<std::size_t>(1, unknown.size() / 3) + 1;
  for (const auto& candidate : all) {
    const std::size_t distance = edit_distance(name(candidate), unknown);
    if (distance >= least) continue;
    least = distance;
    best = &candidate;
  }
  return best;
}

/// The first key of that name anywhere in the tree.
const KeyNode* elsewhere(const KeyNode& section, std::string_view name) {
  for (const auto& key : section.children) {
    if (key.info.name == name) return &key;
    if (const KeyNode* found = elsewhere(key, name)) return found;
  }
  return nullptr;
}

std::vector<std::string_view> names_of_keys(const KeyNode& section) {
  std::vector<std::string_view> out;
  for (const KeyNode& key : section.children) out.push_back(key.info.name);
  return out;
}

/// Whether a step is an index that a list may have.
bool is_index(const std::string& step) {
  constexpr std::size_t kMostDigits = 6;
  return step.size() <= kMostDigits && is_whole_number(step);
}

}  // namespace

std::string suggest_key(const KeyNode& section, const std::string& unknown) {
  if (unknown.size() <= kLongestKey) {
    for (const auto& key : section.children) {
      if (differs_in_unit_only(key, unknown)) return "did you mean " + display(key) + "?";
    }
    if (const KeyNode* key = elsewhere(key_tree(), unknown)) return "did you mean " + key->path + "?";
    const auto name = [](const KeyNode& key) { return key.info.name; };
    if (const KeyNode* key = nearest(section.children, unknown, name)) return "did you mean " + display(*key) + "?";
  }
  return "expected one of " + join_or(names_of_keys(section));
}

std::string suggest_word(const std::vector<std::string_view>& words, const std::string& unknown) {
  if (unknown.size() <= kLongestKey) {
    if (const auto* word = nearest(words, unknown, std::identity())) return "did you mean " + std::string(*word) + "?";
  }
  return "expected " + join_or(words);
}

const KeyNode& find_key(const std::string& path, const SourceLocation& where) {
  const KeyNode* at = &key_tree();
  std::string so_far;
  bool in_list = false;
  for (const std::string& step : split(path, '.')) {
    const std::string name = so_far + (so_far.empty() ? "" : ".") + shown_key(step);
    if (at->info.kind == KeyKind::list && !in_list) {
      if (!is_index(step)) throw InputError(where, name, "unknown key", "expected an index into the list " + so_far);
      in_list = true;
    } else {
      const bool has_keys = at->info.kind == KeyKind::section || in_list;
      if (!has_keys) throw InputError(where, name, "unknown key", so_far + " has no keys below it");
      const KeyNode* next = at->find(step);
      if (next == nullptr) throw InputError(where, name, "unknown key", suggest_key(*at, step));
      at = next;
      in_list = false;
    }
    so_far = name;
  }
  const bool is_list = at->info.kind == KeyKind::list;
  if (at->info.kind == KeyKind::section || is_list) {
    const std::vector<std::string_view> names = names_of_keys(*at);
    const std::string remedy = is_list && !in_list
                                   ? "name a key of an entry, as in " + so_far + ".0." + std::string(names[0])
                                   : "name one of its keys: " + join_or(names);
    throw InputError(where, so_far, is_list && !in_list ? "is a list" : "is a section", remedy);
  }
  return *at;
}

}  // namespace reamsim
