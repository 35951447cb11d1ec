#pragma once

#include <string>

#include "sim/base/geometry.h"
#include "sim/base/report.h"

namespace reamsim {

/// Throws InputError where the longest side of a bone with a glenoid frame is not 20 to 400 mm: the mesh is in another
/// unit. The message names the scales that would fit. Without a frame any solid may be reamed, so that sizes beyond 10
/// to 400 mm are warned of. `scale` is the one that `bounds_mm` has already.
void check_mesh_unit(const std::string& path, const Aabb& bounds_mm, double scale, bool has_glenoid, Report& report);

}  // namespace reamsim
