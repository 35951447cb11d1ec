// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <string>

#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

struct WeldResult {
  std::size_t corners = 0;  ///< that were moved to another one
  double farthest_mm = 0;   ///< the most that one was moved
  double tolerance_mm = 0;  ///< 0: not welded, because the mesh is closed

  /// "12 corners welded, ..."; "" where none was.
  [[nodiscard]] std::string text() const;
};

/// Merges vertices that differ in their last digits, as programs write them that transform each triangle by itself:
/// only those at the edges of holes, within 10⁻⁵ of the size of the mesh and a tenth of its shortest edge. An edge that
/// is shorter than the rounding of the coordinates is none. A mesh without holes is not changed.
WeldResult weld(TriangleMesh& mesh);

}  // namespace reamsim
