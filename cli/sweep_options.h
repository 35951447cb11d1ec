#pragma once

#include <string>
#include <vector>

#include "sim/study/identify.h"

namespace CLI {
class App;
}

namespace reamsim {

/// The arguments that all commands of `sweep` share.
struct SweepOptions {
  std::string file;
  std::string output;
  std::vector<std::string> overrides;

  void add_to(CLI::App& command);
  /// DIR of -o, else out/NAME of the study.
  [[nodiscard]] std::string dir(const Study& study) const;
};

/// A study, its plan, and the names of its runs.
struct SweepRuns {
  Study study;
  StudyPlan plan;
  std::vector<IdentifiedRun> runs;
};

/// Reads the study and parses the scenarios of all runs. Throws InputError for a wrong study.
SweepRuns load_sweep(const SweepOptions& options);

}  // namespace reamsim
