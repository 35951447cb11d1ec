// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cmath>
#include <string>

#include "sim/mesh/mesh_io.h"

namespace reamsim::test {

/// Path of a shipped reamer: "convex", "convex_edges", "flat", "hemispherical".
inline std::string reamer_path(const std::string& name) {
  return std::string(REAMSIM_ASSETS) + "/reamer_" + name + ".stl";
}

inline TriangleMesh reamer(const std::string& name) {
  return read_mesh(reamer_path(name), 1);
}

inline double radius_of(const Vec3& p) {
  return std::hypot(p.x(), p.y());
}

}  // namespace reamsim::test
