// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "sim/base/geometry.h"
#include "sim/base/report.h"

namespace reamsim {

/// Throws InputError if the longest side of a bone with a glenoid frame is not 20 to 400 mm: the mesh has another unit.
/// The message lists the scales that would fit. Without a frame any solid may be reamed, and a size beyond 10 to 400 mm
/// is a warning. `bounds_mm` includes `scale`.
void check_mesh_unit(const std::string& path, const Aabb& bounds_mm, double scale, bool has_glenoid, Report& report);

}  // namespace reamsim
