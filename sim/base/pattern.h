// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <memory>
#include <string>

namespace reamsim {

/// A regular expression in ECMAScript's grammar. A class of its own because std::regex takes seconds to compile in each
/// file that uses it. Throws std::regex_error.
class Pattern {
 public:
  explicit Pattern(const std::string& expression);

  /// Whether the expression describes the whole text.
  [[nodiscard]] bool matches(const std::string& text) const;

 private:
  struct Compiled;
  std::shared_ptr<const Compiled> compiled_;
};

}  // namespace reamsim
