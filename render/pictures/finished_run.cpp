#include "render/pictures/finished_run.h"

#include <optional>
#include <utility>

#include "render/pictures/results.h"

namespace reamsim {

struct FinishedRun::Loaded {
  explicit Loaded(const std::string& dir) : results(read_results(dir)), planned(read_plan(dir, results)) {}
  Loaded(const PlannedRun& has_run, const FillBricks& fill)
      : results(read_results(has_run.plan().dir, has_run.plan().bone, fill)), planned(has_run) {}

  RunResults results;
  PlannedRun planned;
};

struct FinishedRun::Folder {
  std::string dir;
  std::optional<PlannedRun> has_run;
  FillBricks fill;  ///< that it left
  std::optional<Loaded> loaded;
};

FinishedRun::FinishedRun(std::string dir) : folder_(new Folder{std::move(dir), std::nullopt, {}, std::nullopt}) {}

FinishedRun::FinishedRun(const PlannedRun& planned, FillBricks fill)
    : folder_(new Folder{planned.plan().dir, planned, std::move(fill), std::nullopt}) {}

const std::string& FinishedRun::dir() const {
  return folder_->dir;
}

const RunResults& FinishedRun::results() const {
  return loaded().results;
}

const PlannedRun& FinishedRun::planned() const {
  return loaded().planned;
}

const FinishedRun::Loaded& FinishedRun::loaded() const {
  Folder& folder = *folder_;
  if (!folder.loaded) {
    if (folder.has_run) {
      folder.loaded.emplace(*folder.has_run, folder.fill);
    } else {
      folder.loaded.emplace(folder.dir);
    }
  }
  return *folder.loaded;
}

}  // namespace reamsim
