#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/base/error.h"

namespace reamsim {

/// Mistakes that are collected, so that a user hears of all of them at once.
class MistakeList {
 public:
  void add(const InputError& error);

  /// Does `work`, keeps the mistakes of an InputError, and says whether there was none.
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

  /// A key that may be wrong because of a mistake elsewhere; it counts for concerns() alone.
  void doubt(std::string key) { doubted_.push_back(std::move(key)); }

  [[nodiscard]] bool empty() const { return mistakes_.empty(); }
  /// Whether one of them, or a doubt, concerns `key`, a key above it or a key below it.
  [[nodiscard]] bool concerns(std::string_view key) const;
  /// Whether one of them concerns a key that stands directly in the section `section`.
  [[nodiscard]] bool has_key_in(std::string_view section) const;

  /// Throws an InputError of all mistakes, by line and column, at most 50. Does nothing without any.
  void throw_if_any() const;

 private:
  std::vector<Mistake> mistakes_;
  std::vector<std::string> doubted_;
};

}  // namespace reamsim
