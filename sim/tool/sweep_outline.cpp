// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_map>

#include "sim/base/error.h"
#include "sim/tool/envelope.h"
#include "sim/tool/polyline.h"
#include "sim/tool/swept_section.h"

namespace reamsim {

namespace {

constexpr double kMaxLatticePoints = 4096;
/// Offsets of the lattice lines from round numbers, where designed surfaces lie. The first column is the axis.
constexpr double kColumnShift = 0.382;
constexpr double kRowShift = 0.618;
/// Bisections of a vertical crossing: 0.02 mm / 2^9 = 0.04 µm.
constexpr int kBisections = 9;
/// Tolerance of the simplified outline, steps.
constexpr double kSimplifySteps = 0.2;
/// A second part of at most this fraction of the area is an artefact of the lattice.
constexpr double kArtefactFraction = 1e-3;

/// The lattice of sample points: column 0 is the axis, row 0 lies below the mesh and the last row above it.
class Lattice {
 public:
  Lattice(const SweptSection& section, const Aabb& box, double radius_mm, double step_mm)
      : section_(section), bottom_mm_(box.min.z()) {
    const double height = box.max.z() - box.min.z();
    step_mm_ = std::max(step_mm, std::max(radius_mm, height) / (kMaxLatticePoints - 4));
    columns_ = static_cast<int>(std::ceil(radius_mm / step_mm_)) + 2;
    rows_ = static_cast<int>(std::ceil(height / step_mm_)) + 2;
    for (int j = 0; j < rows_; ++j) intervals_.push_back(section.at(z(j)));
  }

  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] double step_mm() const { return step_mm_; }
  [[nodiscard]] double r(int i) const { return i == 0 ? 0.0 : (i - kColumnShift) * step_mm_; }
  [[nodiscard]] double z(int j) const { return bottom_mm_ + (j - kRowShift) * step_mm_; }

  /// Column −1, beyond the axis, is outside.
  [[nodiscard]] bool inside(int i, int j) const {
    return i >= 0 && occupied(intervals_[static_cast<std::size_t>(j)], r(i));
  }

  /// The crossing of the outline between columns i and i + 1 of row j.
  [[nodiscard]] Vec2 crossing_along_row(int i, int j) const {
    const auto& row = intervals_[static_cast<std::size_t>(j)];
    const bool leaves = inside(i, j);
    const double radius = leaves ? r(i) : r(i + 1);
    const auto it = std::find_if(row.begin(), row.end(), [&](const auto& v) { return radius <= v.high; });
    return {leaves ? it->high : std::max(0.0, it->low), z(j)};
  }

  /// The crossing of the outline between rows j and j + 1 of column i.
  [[nodiscard]] Vec2 crossing_along_column(int i, int j) const {
    const bool inside_below = inside(i, j);
    double below = z(j), above = z(j + 1);
    for (int k = 0; k < kBisections; ++k) {
      const double middle = 0.5 * (below + above);
      (occupied(section_.at(middle), r(i)) == inside_below ? below : above) = middle;
    }
    return {r(i), 0.5 * (below + above)};
  }

 private:
  const SweptSection& section_;
  double bottom_mm_;
  double step_mm_ = 0;
  int columns_ = 0;
  int rows_ = 0;
  std::vector<std::vector<SweptSection::Interval>> intervals_;
};

/// A lattice edge: from point (i, j) to (i + 1, j), or to (i, j + 1).
struct LatticeEdge {
  int i;
  int j;
  bool along_row;

  [[nodiscard]] std::int64_t key() const { return ((std::int64_t{j} << 16) + i + 1) * 2 + (along_row ? 1 : 0); }
  static LatticeEdge of(std::int64_t key) {
    return {static_cast<int>((key >> 1) & 0xffff) - 1, static_cast<int>(key >> 17), (key & 1) != 0};
  }
};

using Successors = std::unordered_map<std::int64_t, std::int64_t>;

/// Marching squares: for each lattice edge that the outline crosses, the next one, with the inside on the left.
/// Opposite inside corners of a cell are not connected.
Successors link_crossings(const Lattice& lattice) {
  Successors next;
  for (int j = 0; j + 1 < lattice.rows(); ++j) {
    for (int i = -1; i + 1 < lattice.columns(); ++i) {
      const bool in[4] = {lattice.inside(i, j), lattice.inside(i + 1, j), lattice.inside(i + 1, j + 1),
                          lattice.inside(i, j + 1)};
      const LatticeEdge edge[4] = {{i, j, true}, {i + 1, j, false}, {i, j + 1, true}, {i, j, false}};
      for (int k = 0; k < 4; ++k) {
        if (!in[k] || in[(k + 1) % 4]) continue;
        // Counter-clockwise around the cell the outline begins at a change from inside to outside, and ends at the
        // previous change from outside to inside.
        int from = (k + 3) % 4;
        while (in[from]) from = (from + 3) % 4;
        next[edge[k].key()] = edge[from].key();
      }
    }
  }
  return next;
}

std::vector<Vec2> trace_loop(const Lattice& lattice, Successors& next) {
  std::vector<Vec2> loop;
  for (auto it = next.begin(); it != next.end();) {
    const LatticeEdge edge = LatticeEdge::of(it->first);
    loop.push_back(edge.along_row ? lattice.crossing_along_row(edge.i, edge.j)
                                  : lattice.crossing_along_column(edge.i, edge.j));
    const std::int64_t following = it->second;
    next.erase(it);
    it = next.find(following);
  }
  return loop;
}

}  // namespace

Profile sweep_outline(const TriangleMesh& mesh, double step_mm) {
  double radius = 0;
  for (const Vec3& p : mesh.vertices) radius = std::max(radius, std::hypot(p.x(), p.y()));
  const SweptSection section(mesh);
  const Lattice lattice(section, mesh.bounds(), radius, step_mm);
  Successors next = link_crossings(lattice);
  std::vector<Vec2> largest;
  double largest_area = 0, other_area = 0;
  while (!next.empty()) {
    std::vector<Vec2> loop = trace_loop(lattice, next);
    const double area = signed_area(loop);
    if (area > largest_area) {
      other_area = std::max(other_area, largest_area);
      largest_area = area;
      largest = std::move(loop);
    } else {
      other_area = std::max(other_area, area);  // cavities are clockwise and have negative area
    }
  }
  if (other_area > kArtefactFraction * largest_area)
    throw InputError("its envelope of revolution about z has several separate parts; give one connected tool");
  return {sharpen_corners(simplify(largest, kSimplifySteps * lattice.step_mm()), lattice.step_mm())};
}

Envelope envelope_of_revolution(const TriangleMesh& mesh) {
  if (auto profile = recover_generatrix(mesh)) return {std::move(*profile), true};
  Profile profile = sweep_outline(mesh, kOutlineStepMm);
  if (profile.points.size() < 3 || !(profile.volume_mm3() > 0))
    throw InputError("its envelope of revolution about z has no volume");
  return {std::move(profile), false};
}

}  // namespace reamsim
