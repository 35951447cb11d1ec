// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <fmt/core.h>
#include <string>

#include "sim/base/geometry.h"

namespace reamsim::ct {

inline std::string point_text(const Vec3& p) {
  return fmt::format("({:.1f}, {:.1f}, {:.1f})", p.x(), p.y(), p.z());
}

inline std::string box_text(const Aabb& box) {
  return point_text(box.min) + " to " + point_text(box.max) + " mm";
}

}  // namespace reamsim::ct
