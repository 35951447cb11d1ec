// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <map>

#include "sim/base/error.h"
#include "sim/bone/implicit.h"
#include "sim/mesh/winding.h"
#include "sim/tool/profile.h"

namespace reamsim {

namespace {

constexpr std::size_t kMaxSlabs = 256;
/// Limit of the slab table where every triangle spans the full height.
constexpr std::size_t kMaxSlabEntries = 50'000'000;

/// Radii from `low` to `high`, mm.
struct Interval {
  double low;
  double high;
};

/// A piece of a section, with the inside on its left.
struct Piece {
  Vec2 from, to;
};

/// The point of edge a–b at height z, computed from the lower end so that both triangles of an edge agree.
Vec2 crossing(const Vec3& a, const Vec3& b, double z) {
  const Vec3& low = a.z() < b.z() ? a : b;
  const Vec3& high = a.z() < b.z() ? b : a;
  const double t = (z - low.z()) / (high.z() - low.z());
  return low.head<2>() + t * (high - low).head<2>();
}

std::vector<Interval> merge(std::vector<Interval> intervals) {
  std::sort(intervals.begin(), intervals.end(), [](const auto& a, const auto& b) { return a.low < b.low; });
  std::vector<Interval> merged;
  for (const auto& i : intervals) {
    if (!merged.empty() && i.low <= merged.back().high)
      merged.back().high = std::max(merged.back().high, i.high);
    else
      merged.push_back(i);
  }
  return merged;
}

/// The radii that a rotating mesh occupies at a height. Each piece of its section, a set of closed curves, sweeps an
/// interval of radii. The circle of any other radius lies entirely inside or outside, as its winding number tells.
class SweptSection {
 public:
  /// The mesh (closed, facing outwards; mm, frame T) must outlive the section.
  explicit SweptSection(const TriangleMesh& mesh)
      : mesh_(mesh),
        slabs_(
            mesh, 2,
            std::clamp<std::size_t>(kMaxSlabEntries / std::max<std::size_t>(1, mesh.triangles.size()), 1, kMaxSlabs)) {}

  /// The occupied radii at height `z_mm`: disjoint, ascending.
  [[nodiscard]] std::vector<Interval> at(double z_mm) const {
    const std::vector<Piece> pieces = cut(z_mm);
    std::vector<Interval> swept;
    for (const Piece& p : pieces) {
      swept.push_back(
          {implicit::distance_to_segment(Vec2::Zero(), p.from, p.to), std::max(p.from.norm(), p.to.norm())});
    }
    swept = merge(std::move(swept));

    // Winding number of the section about (radius, 0), from the pieces that a ray along +x crosses.
    const auto inside = [&](double radius) {
      int winding = 0;
      for (const Piece& p : pieces) {
        if ((p.from.y() <= 0) == (p.to.y() <= 0)) continue;
        const double x = p.from.x() - p.from.y() * (p.to.x() - p.from.x()) / (p.to.y() - p.from.y());
        if (x > radius) winding += p.to.y() > p.from.y() ? 1 : -1;
      }
      return winding > 0;
    };
    std::vector<Interval> gaps;
    double low = 0;
    for (const Interval& i : swept) {
      if (i.low > low && inside(0.5 * (low + i.low))) gaps.push_back({low, i.low});
      low = i.high;
    }
    swept.insert(swept.end(), gaps.begin(), gaps.end());
    return merge(std::move(swept));
  }

 private:
  [[nodiscard]] std::vector<Piece> cut(double z_mm) const {
    std::vector<Piece> pieces;
    for (const std::uint32_t t : slabs_.at(z_mm)) {
      const std::array<Vec3, 3> v = mesh_.corners(mesh_.triangles[t]);
      Piece piece{Vec2::Zero(), Vec2::Zero()};
      bool crosses = false;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 &from = v[k], &to = v[(k + 1) % 3];
        // Half open, so that a vertex at this height is consistent.
        const bool above = from.z() >= z_mm;
        if (above == (to.z() >= z_mm)) continue;
        crosses = true;
        // Seen from outside, counter-clockwise: the section begins at a descending edge and ends at an ascending one.
        (above ? piece.from : piece.to) = crossing(from, to, z_mm);
      }
      if (crosses) pieces.push_back(piece);
    }
    return pieces;
  }

  const TriangleMesh& mesh_;
  TriangleRows slabs_;  ///< by height
};

/// Whether `radius_mm` lies in one of the intervals.
bool occupied(const std::vector<Interval>& intervals, double radius_mm) {
  return std::any_of(intervals.begin(), intervals.end(),
                     [&](const auto& i) { return radius_mm >= i.low && radius_mm <= i.high; });
}

constexpr double kMaxLatticePoints = 4096;
/// Offsets of the lattice lines from round numbers, where designed surfaces lie. The first column is the axis.
constexpr double kColumnShift = 0.382;
constexpr double kRowShift = 0.618;
constexpr int kBisections = 9;          // bisections of a vertical crossing: 0.02 mm / 2^9 = 0.04 µm
constexpr double kSimplifySteps = 0.2;  // tolerance of the simplified outline, steps
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
    const auto as_below = [&](double z_mm) { return occupied(section_.at(z_mm), r(i)) == inside_below; };
    return {r(i), implicit::bisect(z(j), z(j + 1), kBisections, as_below).middle()};
  }

 private:
  const SweptSection& section_;
  double bottom_mm_;
  double step_mm_ = 0;
  int columns_ = 0;
  int rows_ = 0;
  std::vector<std::vector<Interval>> intervals_;
};

/// A lattice edge: from point (i, j) to (i + 1, j), or to (i, j + 1).
struct LatticeEdge {
  int i;
  int j;
  bool along_row;

  auto operator<=>(const LatticeEdge&) const = default;
};

using Successors = std::map<LatticeEdge, LatticeEdge>;

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
        // Counter-clockwise round the cell it begins at a change to outside, and ends at the previous change to inside.
        int from = (k + 3) % 4;
        while (in[from]) from = (from + 3) % 4;
        next[edge[k]] = edge[from];
      }
    }
  }
  return next;
}

std::vector<Vec2> trace_loop(const Lattice& lattice, Successors& next) {
  std::vector<Vec2> loop;
  for (auto it = next.begin(); it != next.end();) {
    const auto [edge, following] = *it;
    loop.push_back(edge.along_row ? lattice.crossing_along_row(edge.i, edge.j)
                                  : lattice.crossing_along_column(edge.i, edge.j));
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
