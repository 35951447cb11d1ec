#pragma once

namespace reamsim {

/// Returns memory that was freed to the system. Call it after a stage with much temporary memory: the C library would
/// keep it, and the next stage would add to the peak.
void return_free_memory();

}  // namespace reamsim
