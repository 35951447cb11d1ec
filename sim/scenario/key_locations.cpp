// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/key_locations.h"

#include <utility>
#include <vector>

namespace reamsim {

void KeyLocations::set(const std::string& path, const SourceLocation& where, bool given) {
  places_[path] = {where, given};
}

SourceLocation KeyLocations::of(const std::string& path) const {
  const auto found = places_.find(path);
  return found == places_.end() ? SourceLocation{} : found->second.where;
}

bool KeyLocations::given(const std::string& path) const {
  const auto found = places_.find(path);
  return found != places_.end() && found->second.given;
}

InputError KeyLocations::located(const InputError& error) const {
  std::vector<Mistake> mistakes = error.mistakes();
  for (Mistake& mistake : mistakes) {
    if (mistake.where.file.empty() && !mistake.key.empty()) mistake.where = of(mistake.key);
  }
  return InputError(std::move(mistakes));
}

}  // namespace reamsim
