// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/mesh/triangle_mesh.h"
#include "sim/scenario/metric_settings.h"

namespace reamsim {

/// A point of the surface of a peg, in the frame of the implant.
struct PegPoint {
  Vec3 at_mm;
  Vec3 outward;  ///< of length 1
};

/// The surface of a peg as far as its wall is measured.
struct PegSurface {
  struct Circumference {
    Vec3 center_mm = Vec3::Zero();
    double length_mm = 0;  ///< of the axis, to the next circumference
    std::vector<PegPoint> points{};
  };
  std::vector<Circumference> circumferences;  ///< from the back down
  std::vector<PegPoint> rays;                 ///< along which the wall is measured
  std::pair<Vec3, Vec3> axis_mm;
};

/// A peg whose points are all within diameter/2 of a segment. `step_mm`: largest distance between circumferences.
PegSurface capsule_surface(const PegSettings& peg, double step_mm);

/// Reads the mesh of ImplantSettings::mesh. Throws InputError: no closed surface, a size that is not supported, an
/// underside that is not at the plain back.
TriangleMesh read_implant_mesh(const ImplantSettings& settings, Diagnostics& report);

/// The parts of a mesh with a vertex for which `is_peg` is true, in the order of the mesh, by points of the surface at
/// most `step_mm` apart in layers across z as thick.
std::vector<PegSurface> peg_surfaces(const TriangleMesh& mesh, const std::function<bool(const Vec3&)>& is_peg,
                                     double step_mm);

}  // namespace reamsim
