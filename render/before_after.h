#pragma once

#include <string>
#include <vector>

#include "render/studio.h"

namespace reamsim {

/// One picture with the bone before and after, side by side, seen by one camera.
class BeforeAfter {
 public:
  /// Takes the right half: the bone that the studio shows now. `camera`: its name. `values`: name and number with
  /// unit, one per line, for that half.
  BeforeAfter(Studio& studio, const std::string& camera, std::vector<std::pair<std::string, std::string>> values);

  /// Takes the left half and returns the whole, of the size that the settings say.
  [[nodiscard]] PixelImage finish(Studio& studio) const;
  /// The camera's name.
  [[nodiscard]] const std::string& camera() const { return camera_.name; }

 private:
  Camera camera_;
  std::vector<std::pair<std::string, std::string>> values_;
  PixelImage after_;
};

}  // namespace reamsim
