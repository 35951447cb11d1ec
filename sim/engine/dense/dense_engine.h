#pragma once

#include <memory>

#include "sim/engine/common/engine.h"

namespace reamsim {

/// The engines with a dense array of voxels (`direct`, `octree`, `implicit`), on the scenario's device.
std::unique_ptr<Engine> make_dense_engine(const Scenario& scenario, const BoneView& bone, const Tool& tool);

}  // namespace reamsim
