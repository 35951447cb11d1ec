#pragma once

#include <nlohmann/json.hpp>

#include "render/pictures/run_data.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// What the page's 3D view needs, all in B and mm: `before` and `after`, the bone's surface as mesh_bytes() packs it;
/// `density`, a volume for cuts; colour maps; where to look, and which planes to cut along.
nlohmann::ordered_json bone_data(const RunData& run, const RenderSettings& settings);

}  // namespace reamsim
