// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/base/geometry.h"

namespace reamsim {

/// Whether the triangle abc shares a point with the closed box about `center` with half edges `half` (any one unit).
/// Separating axes: the box's three, the triangle's normal, and the nine cross products of edges
/// (Akenine-Möller 2001, "Fast 3D triangle-box overlap testing").
bool triangle_touches_box(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& center, const Vec3& half);

}  // namespace reamsim
