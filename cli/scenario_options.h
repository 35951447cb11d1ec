#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace reamsim {

/// The arguments that `run` and `check` share.
struct ScenarioOptions {
  std::string file;
  std::vector<std::string> overrides;
  std::string device;
  std::string engine;

  void add_to(CLI::App& command);
  /// `--set`, and `--device` and `--engine` as settings of their keys.
  [[nodiscard]] std::vector<std::string> all_overrides() const;
};

}  // namespace reamsim
