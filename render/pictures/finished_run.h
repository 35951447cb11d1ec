#pragma once

#include <memory>
#include <string>

#include "render/pictures/planned_run.h"

namespace reamsim {

struct RunResults;

/// The folder of a finished run, and what pictures, meshes and the report all need of it: read and computed when it is
/// first asked for, and only once. Copies share it. Where one is wanted, a folder's path will do.
class FinishedRun {
 public:
  FinishedRun(std::string dir);  // not explicit on purpose
  /// Of a plan that has just been run and left this fill. Faster, and no other for it.
  FinishedRun(const PlannedRun& planned, FillBricks fill);

  [[nodiscard]] const std::string& dir() const;
  // These throw as read_results() and read_plan() do.
  [[nodiscard]] const RunResults& results() const;
  [[nodiscard]] const PlannedRun& planned() const;

 private:
  struct Loaded;
  struct Folder;

  [[nodiscard]] const Loaded& loaded() const;

  std::shared_ptr<Folder> folder_;  ///< keeps OpenVDB out of this header
};

}  // namespace reamsim
