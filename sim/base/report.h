#pragma once

#include <functional>
#include <string>
#include <vector>

namespace reamsim {

/// Messages of a stage for the user. The caller prints them, so that no engine prints.
struct Report {
  std::vector<std::string> notes;
  std::vector<std::string> warnings;

  void note(std::string text) { notes.push_back(std::move(text)); }
  void warn(std::string text) { warnings.push_back(std::move(text)); }
};

}  // namespace reamsim
