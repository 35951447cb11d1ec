#pragma once

#include <string>
#include <utility>
#include <vector>

#include "render/pictures/run_view.h"

namespace reamsim {

/// The camera called `name` for one half of a picture with the bone before and after, side by side. The whole has the
/// settings' size.
Camera half_camera(const RunView& view, const std::string& name);

/// Puts such a picture together from its halves. `values`: name and number with unit, one per line, for the right one.
PixelImage before_and_after(const RunView& view, const Camera& half, const PixelImage& before, const PixelImage& after,
                            const std::vector<std::pair<std::string, std::string>>& values);

}  // namespace reamsim
