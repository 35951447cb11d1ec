#pragma once

#include <vector>

#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// Answers which radii a turning mesh occupies at a height. At height z the mesh's section is a set of closed curves;
/// turning sweeps each of their pieces over an interval of radii. A radius that no piece sweeps has its whole circle
/// either inside or outside the mesh, which one winding number decides.
class SweptSection {
 public:
  /// Radii from `low` to `high`, mm.
  struct Interval {
    double low;
    double high;
  };

  /// Keeps a reference to the mesh (closed, facing outwards; mm, frame T).
  explicit SweptSection(const TriangleMesh& mesh);

  /// The occupied radii at height `z_mm`: disjoint, ascending.
  [[nodiscard]] std::vector<Interval> at(double z_mm) const;

 private:
  /// A piece of the section, walked with the inside on its left.
  struct Piece {
    Vec2 from, to;
  };

  [[nodiscard]] std::vector<Piece> cut(double z_mm) const;

  const TriangleMesh& mesh_;
  double bottom_mm_ = 0;
  double slab_mm_ = 1;
  std::vector<std::vector<std::int32_t>> slabs_;  ///< triangles by height
};

/// Whether `radius_mm` lies in one of the intervals.
bool occupied(const std::vector<SweptSection::Interval>& intervals, double radius_mm);

}  // namespace reamsim
