#pragma once

#include "render/pictures/run_data.h"

namespace reamsim {

/// Draws DIR/depth_map.csv as DIR/depth_map.png, with the directions that the run knows. `depth_max_mm` ends the
/// legend; 0: the greatest depth does. No picture when nothing was reamed, or the run wrote no map.
/// Throws InputError when a file is damaged, RunError when the picture cannot be written.
void write_depth_picture(const RunData& run, double depth_max_mm);

}  // namespace reamsim
