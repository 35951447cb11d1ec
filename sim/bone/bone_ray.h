// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>

#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

/// Distance along `direction`, a unit vector, at which a ray from `from_mm` (B) first meets bone: a whole voxel, or the
/// part of another one below its plane (voxel_plane()). nullopt where it meets none within `most_mm`.
std::optional<double> first_bone_mm(const BoneView& bone, const Vec3& from_mm, const Vec3& direction, double most_mm);

}  // namespace reamsim
