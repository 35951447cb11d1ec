// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace reamsim {

/// Messages of runs, each text once, with the first run that has it: of many texts the first ten.
class RunMessages {
 public:
  static constexpr std::size_t kMost = 10;

  /// `number`: of a run; each run once.
  void add(int number, const std::vector<std::string>& messages);

  /// How many runs have messages.
  [[nodiscard]] int runs() const { return runs_; }
  /// "run 3 and 2 more: TEXT", at most `most`.
  [[nodiscard]] std::vector<std::string> lines(std::size_t most = kMost) const;

 private:
  struct Text {
    int number;
    int runs;
    std::string message;
  };
  std::vector<Text> texts_;
  int runs_ = 0;
};

}  // namespace reamsim
