#pragma once

#include <cstddef>
#include <memory>

#include "sim/device/opencl.h"
#include "sim/run/engine.h"
#include "sim/run/exact_forecast.h"

namespace reamsim {

/// `erosion: exact` over bricks, on the device that the scenario names. Throws InputError when the bone does not fit.
std::unique_ptr<Engine> make_exact_engine(const Scenario& scenario, const Voxmap& voxmap, const Tool& tool);

/// Device memory that the engine will take at most while it cuts as forecast, bytes.
std::size_t exact_engine_bytes(const ReamingScene& scene, const ExactForecast& forecast);

}  // namespace reamsim
