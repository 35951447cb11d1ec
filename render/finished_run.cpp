#include "render/finished_run.h"

#include <optional>
#include <utility>

#include "render/results.h"
#include "render/unreamed_surface.h"

namespace reamsim {

struct FinishedRun::Loaded {
  explicit Loaded(const std::string& dir)
      : results(read_results(dir)), unreamed(results.voxmap, results.unreamed_fill) {}

  RunResults results;
  UnreamedSurface unreamed;
};

struct FinishedRun::Folder {
  std::string dir;
  std::optional<Loaded> loaded;
};

FinishedRun::FinishedRun(std::string dir) : folder_(new Folder{std::move(dir), std::nullopt}) {}

const std::string& FinishedRun::dir() const {
  return folder_->dir;
}

RunResults& FinishedRun::results() const {
  return loaded().results;
}

const UnreamedSurface& FinishedRun::unreamed() const {
  return loaded().unreamed;
}

FinishedRun::Loaded& FinishedRun::loaded() const {
  if (!folder_->loaded) folder_->loaded.emplace(folder_->dir);
  return *folder_->loaded;
}

}  // namespace reamsim
