// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "sim/base/error.h"

namespace reamsim {

/// The place of each key in the scenario file, by path ("motion.keyframes.0.time_s"). A missing key has the place of
/// its section.
class KeyLocations {
 public:
  void set(const std::string& path, const SourceLocation& where, bool given) { places_[path] = {where, given}; }
  [[nodiscard]] SourceLocation of(const std::string& path) const {
    const auto found = places_.find(path);
    return found == places_.end() ? SourceLocation{} : found->second.where;
  }
  /// Whether the file (or --set) has the key.
  [[nodiscard]] bool given(const std::string& path) const {
    const auto found = places_.find(path);
    return found != places_.end() && found->second.given;
  }
  /// Adds the place of the key to those mistakes that name a key and no place. Mistakes that are found only once the
  /// data are loaded need it.
  [[nodiscard]] InputError located(const InputError& error) const {
    std::vector<Mistake> mistakes = error.mistakes();
    for (Mistake& mistake : mistakes) {
      if (mistake.where.file.empty() && !mistake.key.empty()) mistake.where = of(mistake.key);
    }
    return InputError(std::move(mistakes));
  }
  /// Throws an InputError at a key: `found`, "expected " and `expected`.
  [[noreturn]] void fail(const std::string& key, const std::string& found, const std::string& expected) const {
    throw InputError(of(key), key, found, "expected " + expected);
  }

 private:
  struct Place {
    SourceLocation where;
    bool given = false;
  };
  std::map<std::string, Place> places_;
};

}  // namespace reamsim
