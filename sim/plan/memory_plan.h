#pragma once

#include <cstddef>

#include "sim/run/simulation.h"

namespace reamsim {

/// The most memory that a run of the scene will have held when its results are written, pictures apart.
struct MemoryPlan {
  std::size_t device_bytes = 0;   ///< 0 for the serial engine
  std::size_t process_bytes = 0;  ///< to within a third, as measured; counts the device's as if that were the processor
};
MemoryPlan plan_memory(const ReamingScene& scene);

}  // namespace reamsim
