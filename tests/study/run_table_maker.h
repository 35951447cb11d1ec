// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <limits>
#include <string>
#include <vector>

#include "sim/study/study_folder.h"

namespace reamsim::test {

/// A table of runs that are done.
class TableMaker {
 public:
  TableMaker(std::vector<std::string> parameters, std::vector<std::string> results) {
    table_.parameters = std::move(parameters);
    table_.results = std::move(results);
  }
  TableMaker& done(std::vector<std::string> cells, std::vector<double> numbers) {
    return add(RunState::done, std::move(cells), std::move(numbers), "");
  }
  TableMaker& failed(std::vector<std::string> cells, const std::string& message) {
    return add(RunState::failed, std::move(cells),
               std::vector<double>(table_.results.size(), std::numeric_limits<double>::quiet_NaN()), message);
  }
  [[nodiscard]] const RunTable& table() const { return table_; }

 private:
  TableMaker& add(RunState state, std::vector<std::string> cells, std::vector<double> numbers,
                  const std::string& message) {
    table_.runs.push_back({.number = static_cast<int>(++table_.all),
                           .id = "00000000000000" + std::to_string(10 + table_.all % 90),
                           .state = state,
                           .message = message,
                           .cells = std::move(cells),
                           .numbers = std::move(numbers)});
    return *this;
  }

  RunTable table_;
};

}  // namespace reamsim::test
