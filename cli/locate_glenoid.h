// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/base/diagnostics.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// A point on the face of the glenoid of a bone, for bone.glenoid.near_mm, without any hint: in a CT next to the heads
/// of 16 to 32 mm radius (joints_in_scan()), else by a search of the whole surface (search_faces()). `given`: a mesh
/// or a CT without a glenoid; a known side of a CT excludes the other. Notes what was found, and its confidence. Throws
/// InputError where no place resembles a glenoid, or several do.
Vec3 locate_glenoid(const BoneSettings& given, Diagnostics& report);

}  // namespace reamsim
