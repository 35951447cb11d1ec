#pragma once

#include <string>
#include <vector>

namespace reamsim::bench {

/// A table of text in columns: the first to the left, the others to the right.
class TextTable {
 public:
  void add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
  [[nodiscard]] bool empty() const { return rows_.size() < 2; }
  /// The rows under a title, the first row underlined.
  [[nodiscard]] std::string text(const std::string& title) const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace reamsim::bench
