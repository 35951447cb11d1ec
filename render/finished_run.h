#pragma once

#include <memory>
#include <string>

namespace reamsim {

class FillBricks;
struct RunResults;
struct Voxmap;
class UnreamedBone;
class UnreamedSurface;

/// What drawing a run needs of the bone before it, and takes long to make: of `voxmap` the lattice and the grades
/// alone, which a simulation leaves as they are, and of its fill what it was.
std::shared_ptr<const UnreamedBone> make_unreamed_bone(const Voxmap& voxmap, const FillBricks& fill_before);

/// The folder of a finished run, and what pictures, meshes and the report all need of it: read and computed when it is
/// first asked for, and only once. Copies share it. Where one is wanted, a folder's path will do.
class FinishedRun {
 public:
  FinishedRun(std::string dir);  // not explicit on purpose
  /// With what whoever has just run it still holds: the bone as it was left, and the one before. Faster, and no other
  /// for it.
  FinishedRun(std::string dir, const Voxmap& voxmap, std::shared_ptr<const UnreamedBone> unreamed);

  [[nodiscard]] const std::string& dir() const;
  /// Whoever changes its fill puts it back. Throws as read_results().
  [[nodiscard]] RunResults& results() const;
  /// Throws as read_results().
  [[nodiscard]] const UnreamedSurface& unreamed() const;

 private:
  struct AtHand;
  struct Loaded;
  struct Folder;

  [[nodiscard]] Loaded& loaded() const;

  std::shared_ptr<Folder> folder_;  ///< keeps OpenVDB out of this header
};

}  // namespace reamsim
