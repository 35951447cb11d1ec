// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/base/error.h"

namespace reamsim {

/// Collects mistakes, so that all of them are reported at once.
class MistakeList {
 public:
  void add(const InputError& error);

  /// Calls `work` and adds the mistakes of an InputError. Returns whether there were none.
  template <class Work>
  bool attempt(const Work& work) {
    try {
      work();
      return true;
    } catch (const InputError& error) {
      add(error);
      return false;
    }
  }

  /// Marks a key that may be wrong because of a mistake elsewhere. Only concerns() considers it.
  void doubt(std::string key) { doubted_.push_back(std::move(key)); }

  [[nodiscard]] bool empty() const { return mistakes_.empty(); }
  /// Whether a mistake or a doubted key is `key`, a key above it or a key below it.
  [[nodiscard]] bool concerns(std::string_view key) const;
  /// Whether a mistake concerns a key directly in the section `section`.
  [[nodiscard]] bool has_key_in(std::string_view section) const;

  /// Throws an InputError of all mistakes, by line and column, at most 50. Does nothing where there are none.
  void throw_if_any() const;

 private:
  std::vector<Mistake> mistakes_;
  std::vector<std::string> doubted_;
};

}  // namespace reamsim
