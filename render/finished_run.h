#pragma once

#include <memory>
#include <string>

namespace reamsim {

struct RunResults;
class UnreamedSurface;

/// The folder of a finished run, and what pictures, meshes and the report all need of it: read and computed when it is
/// first asked for, and only once. Copies share it. Where one is wanted, a folder's path will do.
class FinishedRun {
 public:
  FinishedRun(std::string dir);  // not explicit on purpose

  [[nodiscard]] const std::string& dir() const;
  /// Whoever changes its fill puts it back. Throws as read_results().
  [[nodiscard]] RunResults& results() const;
  /// Throws as read_results().
  [[nodiscard]] const UnreamedSurface& unreamed() const;

 private:
  struct Loaded;
  struct Folder;

  [[nodiscard]] Loaded& loaded() const;

  std::shared_ptr<Folder> folder_;  ///< keeps OpenVDB out of this header
};

}  // namespace reamsim
