// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/mesh/winding.h"
#include "sim/scenario/metric_settings.h"

namespace reamsim {

/// A point of the surface of a peg, in the frame of the implant.
struct PegPoint {
  Vec3 at_mm;
  Vec3 outward;  ///< of length 1
};

/// The surface of a peg as far as its wall is measured.
struct PegSurface {
  struct Part {
    Vec3 center_mm;
    double length_mm = 0;  ///< of the axis, between this circumference and the next
    std::vector<PegPoint> points;
  };
  std::vector<Part> circumferences;  ///< from the back down
  std::vector<Part> ends;
  std::pair<Vec3, Vec3> axis_mm{Vec3::Zero(), Vec3::Zero()};
};

/// A peg whose points are all within diameter/2 of a segment. `step_mm`: largest distance between circumferences.
PegSurface capsule_surface(const PegSettings& peg, double step_mm);

/// Reads the mesh of ImplantSettings::mesh. Throws InputError: no closed surface, a size that is not supported, an
/// underside that is not at the plain back.
TriangleMesh read_implant_mesh(const ImplantSettings& settings, Diagnostics& report);

/// The underside of an implant's mesh, in the frame of the implant.
class ImplantUnderside {
 public:
  explicit ImplantUnderside(const TriangleMesh& mesh);

  /// Height of the lowest point of the mesh at a place; nullopt beside it.
  [[nodiscard]] std::optional<double> at(const Vec2& place) const;
  /// Whether the mesh has a point at a place, within a tenth of a millimetre.
  [[nodiscard]] bool covers(const Vec2& place) const;
  /// Half the longer side of the bounding box about the axis.
  [[nodiscard]] double reach_mm() const { return reach_mm_; }

 private:
  LineCrossings lines_;
  double reach_mm_;
  int cells_;  ///< along an edge of `covered_`
  std::vector<std::uint8_t> covered_;
};

/// The parts of a mesh with a vertex for which `is_peg` is true, in the order of the mesh. Circumferences are sections
/// across z, `step_mm` apart; points lie at most `spacing_mm` apart.
std::vector<PegSurface> peg_surfaces(const TriangleMesh& mesh, const std::function<bool(const Vec3&)>& is_peg,
                                     double step_mm, double spacing_mm);

}  // namespace reamsim
