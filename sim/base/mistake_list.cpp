// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/base/mistake_list.h"

#include <algorithm>
#include <string>
#include <tuple>

namespace reamsim {

namespace {

constexpr std::size_t kMostShown = 50;

/// Whether `key` is `above` or below it.
bool is_within(std::string_view key, std::string_view above) {
  return key.starts_with(above) && (key.size() == above.size() || key[above.size()] == '.');
}

}  // namespace

void MistakeList::add(const InputError& error) {
  mistakes_.insert(mistakes_.end(), error.mistakes().begin(), error.mistakes().end());
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
    Mistake rest;
    rest.found = "and " + std::to_string(sorted.size() - kMostShown) + " mistakes more";
    sorted.resize(kMostShown);
    sorted.push_back(rest);
  }
  throw InputError(std::move(sorted));
}

}  // namespace reamsim
