#pragma once

#include <functional>
#include <string>
#include <vector>

namespace reamsim {

/// What a stage wants the user to know: `notes` say what was done, `warnings` what may surprise.
/// A plain sink, so that the engine prints nothing by itself.
struct Report {
  std::vector<std::string> notes;
  std::vector<std::string> warnings;

  void note(std::string text) { notes.push_back(std::move(text)); }
  void warn(std::string text) { warnings.push_back(std::move(text)); }
};

}  // namespace reamsim
