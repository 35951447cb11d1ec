#include "render/finished_run.h"

#include <optional>
#include <utility>

#include "render/results.h"
#include "render/unreamed_surface.h"

namespace reamsim {

std::shared_ptr<const UnreamedBone> make_unreamed_bone(const Voxmap& voxmap, const FillBricks& fill_before) {
  return std::make_shared<UnreamedBone>(voxmap, with_gone_voxels_whole(fill_before));
}

struct FinishedRun::AtHand {
  Voxmap voxmap;
  std::shared_ptr<const UnreamedBone> unreamed;
};

struct FinishedRun::Loaded {
  explicit Loaded(const std::string& dir)
      : results(read_results(dir)), unreamed(results.voxmap, results.unreamed_fill) {}
  Loaded(const std::string& dir, AtHand at_hand)
      : results(read_results(dir, std::move(at_hand.voxmap))), unreamed(std::move(at_hand.unreamed), results.voxmap) {}

  RunResults results;
  UnreamedSurface unreamed;
};

struct FinishedRun::Folder {
  std::string dir;
  std::optional<AtHand> at_hand;  ///< until it is loaded
  std::optional<Loaded> loaded;
};

FinishedRun::FinishedRun(std::string dir) : folder_(new Folder{std::move(dir), std::nullopt, std::nullopt}) {}

FinishedRun::FinishedRun(std::string dir, const Voxmap& voxmap, std::shared_ptr<const UnreamedBone> unreamed)
    : folder_(new Folder{std::move(dir), AtHand{voxmap, std::move(unreamed)}, std::nullopt}) {}

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
  Folder& folder = *folder_;
  if (folder.loaded) return *folder.loaded;
  if (folder.at_hand) {
    folder.loaded.emplace(folder.dir, std::move(*folder.at_hand));
    folder.at_hand.reset();
  } else {
    folder.loaded.emplace(folder.dir);
  }
  return *folder.loaded;
}

}  // namespace reamsim
