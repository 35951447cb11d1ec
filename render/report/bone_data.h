#pragma once

#include <nlohmann/json.hpp>

#include "render/results.h"
#include "render/unreamed_surface.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// What the page's 3D view needs, all in B and mm: `before` and `after`, the bone's surface as mesh_bytes() packs it;
/// `density`, a volume for cuts; colour maps; where to look, and which planes to cut along.
/// `results` end as they came: unreamed bone and last fill.
nlohmann::ordered_json bone_data(RunResults& results, const UnreamedSurface& unreamed, const RenderSettings& settings);

}  // namespace reamsim
