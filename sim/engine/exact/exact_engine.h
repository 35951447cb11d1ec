#pragma once

#include <cstddef>
#include <memory>

#include "sim/device/opencl.h"
#include "sim/engine/common/engine.h"

namespace reamsim {

/// What a run will do to the bone's bricks, at most.
struct ExactForecast {
  std::size_t parted = 0;  ///< bricks that are not whole or that the tool comes to: a page of fill each
  std::size_t listed = 0;  ///< bricks that the tool's surface can meet in one visit
};

/// `erosion: exact` over bricks, on the device that the scenario names. Throws InputError when the bone does not fit.
std::unique_ptr<Engine> make_exact_engine(const Scenario& scenario, const BoneView& bone, const Tool& tool);

/// Device memory that the engine will take at most while it cuts as forecast, bytes.
std::size_t exact_engine_bytes(const BoneView& bone, const Tool& tool, const ExactForecast& forecast);

}  // namespace reamsim
