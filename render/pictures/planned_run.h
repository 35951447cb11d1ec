#pragma once

#include <memory>

#include "render/pictures/run_plan.h"

namespace reamsim {

struct Subject;
class UnreamedSurface;

/// A run's plan, and what takes long to make of it: made once, on a thread of its own that begins at once. Copies share
/// it.
class PlannedRun {
 public:
  explicit PlannedRun(RunPlan plan);

  [[nodiscard]] const RunPlan& plan() const;
  // These wait until it is made. They throw InputError where the tool sweeps no volume.
  [[nodiscard]] const UnreamedSurface& unreamed() const;
  [[nodiscard]] const Subject& subject() const;

 private:
  struct Made;
  struct Shared;

  std::shared_ptr<Shared> shared_;  ///< keeps OpenVDB out of this header
};

}  // namespace reamsim
