#pragma once

#include <cstddef>

#include "sim/run/simulation.h"

namespace reamsim {

/// The most memory that a run of the scene will have held when its results are written, pictures apart, bytes; to
/// within a third, as measured. Counts `device_bytes` in, as if the device were the processor.
std::size_t planned_process_bytes(const ReamingScene& scene, std::size_t device_bytes);

}  // namespace reamsim
