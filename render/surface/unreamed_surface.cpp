// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/surface/solid_field.h"

#define BOOST_ALLOW_DEPRECATED_HEADERS  // Boost 1.74 includes one, and says so

#include <openvdb/math/Proximity.h>

#include <algorithm>
#include <boost/geometry/algorithms/distance.hpp>
#include <boost/geometry/geometries/point.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <boost/geometry/strategies/strategies.hpp>
#include <boost/pending/disjoint_sets.hpp>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numbers>
#include <optional>
#include <utility>

#include "render/surface/scalar_grid.h"
#include "sim/base/parallel.h"
#include "sim/bone/vdb/grids.h"

namespace reamsim {
namespace {

using openvdb::Vec3d;
namespace index = boost::geometry::index;

/// The nearest of some points, at least one.
class NearestPoint {
 public:
  explicit NearestPoint(const std::vector<Vec3>& points) : tree_(entries(points)) {}

  struct Found {
    std::uint32_t index;
    double distance;
  };
  [[nodiscard]] Found operator()(const Vec3& from) const {
    Entry entry;
    tree_.query(index::nearest(Point(from.x(), from.y(), from.z()), 1), &entry);
    const Vec3 point(entry.first.get<0>(), entry.first.get<1>(), entry.first.get<2>());
    return {entry.second, (from - point).norm()};
  }

 private:
  using Point = boost::geometry::model::point<double, 3, boost::geometry::cs::cartesian>;
  using Entry = std::pair<Point, std::uint32_t>;

  static std::vector<Entry> entries(const std::vector<Vec3>& points) {
    std::vector<Entry> out;
    out.reserve(points.size());
    for (const Vec3& p : points) out.emplace_back(Point(p.x(), p.y(), p.z()), static_cast<std::uint32_t>(out.size()));
    return out;
  }

  index::rtree<Entry, index::quadratic<8>> tree_;
};

/// Depth is not measured from the walls of holes and slits up to twice this wide.
constexpr double kClosing_mm = 1.8;
/// Number of depth cells inside the bone. More cost time without benefit, because a distance varies smoothly.
constexpr double kInteriorCells = 400'000;

/// Marks the vertices on the wall of a closed cavity: a part of the surface that encloses a negative volume.
std::vector<bool> walls_of_cavities(const IsoSurface& surface) {
  std::vector<std::uint32_t> rank(surface.points.size()), parent(surface.points.size());
  boost::disjoint_sets components(rank.data(), parent.data());
  for (std::uint32_t i = 0; i < parent.size(); ++i) components.make_set(i);
  for (std::size_t i = 0; i < surface.indices.size(); ++i) {
    components.union_set(surface.indices[i - i % 3], surface.indices[i]);
  }
  std::vector<double> volumes(surface.points.size());  // six times, by the component's first point
  for (std::size_t i = 0; i + 2 < surface.indices.size(); i += 3) {
    const auto at = [&](std::size_t k) -> Vec3 { return surface.points[surface.indices[i + k]].cast<double>(); };
    volumes[components.find_set(surface.indices[i])] += at(0).dot(at(1).cross(at(2)));
  }
  std::vector<bool> out(surface.points.size());
  for (std::uint32_t i = 0; i < out.size(); ++i) out[i] = volumes[components.find_set(i)] < 0;
  return out;
}

/// The distance from the unreamed surface near a box, and from closed cavities; negative inside the bone and in them.
/// In the space of voxel indices times voxel_mm.
class SurfaceDistance {
 public:
  SurfaceDistance(const UnreamedSurface& unreamed, double voxel_mm, const Eigen::AlignedBox3d& near_mm)
      : voxel_mm_(voxel_mm), field_(*unreamed.field.grid().vdb) {
    const IsoSurface& surface = unreamed.surface;
    const std::vector<bool> in_cavity = walls_of_cavities(surface);
    std::vector<std::uint32_t> number(surface.points.size(), kLeftOut);
    for (std::size_t i = 0; i < number.size(); ++i) {
      const Vec3 mm = voxel_mm * surface.points[i].cast<double>();
      if (!in_cavity[i] && !near_mm.contains(mm)) continue;
      number[i] = static_cast<std::uint32_t>(points_.size());
      points_.push_back(mm);
      in_cavity_.push_back(in_cavity[i]);
    }
    std::vector<std::uint32_t> indices;
    for (std::size_t i = 0; i + 2 < surface.indices.size(); i += 3) {
      const std::uint32_t corners[] = {number[surface.indices[i]], number[surface.indices[i + 1]],
                                       number[surface.indices[i + 2]]};
      if (std::ranges::count(corners, kLeftOut) == 0)
        indices.insert(indices.end(), std::begin(corners), std::end(corners));
    }
    triangles_.emplace(points_.size(), indices);
    nearest_.emplace(points_);
  }

  /// Whether there is no such surface; then the distance must not be asked for.
  [[nodiscard]] bool empty() const { return points_.empty(); }
  [[nodiscard]] openvdb::FloatGrid::ConstAccessor accessor() const { return field_.getConstAccessor(); }

  [[nodiscard]] double at(const Vec3& mm, const openvdb::FloatGrid::ConstAccessor& field) const {
    const std::uint32_t vertex = (*nearest_)(mm).index;
    const double distance = (closest_point(vertex, mm) - mm).norm();
    return in_cavity_[vertex] || sample(field, vdb_point(mm) / voxel_mm_) < 0 ? -distance : distance;
  }
  [[nodiscard]] Vec3 closest_point(const Vec3& mm) const { return closest_point((*nearest_)(mm).index, mm); }

 private:
  static constexpr std::uint32_t kLeftOut = UINT32_MAX;

  /// On the triangles at the nearest vertex.
  [[nodiscard]] Vec3 closest_point(std::uint32_t vertex, const Vec3& mm) const {
    Vec3 best = points_[vertex];
    const auto second = triangles_->of(vertex), third = triangles_->opposite(vertex);
    for (std::size_t i = 0; i < second.size(); ++i) {
      Vec3d weights;
      const Vec3d on_triangle =
          openvdb::math::closestPointOnTriangleToPoint(vdb_point(points_[vertex]), vdb_point(points_[second[i]]),
                                                       vdb_point(points_[third[i]]), vdb_point(mm), weights);
      const Vec3 point(on_triangle.x(), on_triangle.y(), on_triangle.z());
      if ((point - mm).squaredNorm() < (best - mm).squaredNorm()) best = point;
    }
    return best;
  }

  double voxel_mm_;
  const openvdb::FloatGrid& field_;
  std::vector<Vec3> points_;
  std::vector<bool> in_cavity_;  ///< by point
  std::optional<Neighbours> triangles_;
  std::optional<NearestPoint> nearest_;
};

using Leaf = openvdb::FloatTree::LeafNodeType;

/// Calls visit(leaf) for all leaves of a grid at once.
template <class Visit>
void for_each_leaf(openvdb::FloatGrid& grid, const Visit& visit) {
  std::vector<Leaf*> leaves;
  grid.tree().getNodes(leaves);
  parallel_items(leaves.size(), [&](std::size_t i) { visit(*leaves[i]); });
}

/// The surface offset outwards by kClosing_mm, which closes narrow holes (morphological closing), in a box. Cells
/// beside it get their distance. Cubes further away are recognised by the distance at their centre and not subdivided.
class OffsetSampler {
 public:
  OffsetSampler(const SurfaceDistance& distance, double cell_mm) : distance_(distance), cell_mm_(cell_mm) {}

  /// In the space of voxel indices times voxel_mm.
  [[nodiscard]] IsoSurface sample_box(const Eigen::AlignedBox3d& box_mm) {
    constexpr int kFirst = 64;  // cells along the side of a cube
    grid_->setTransform(openvdb::math::Transform::createLinearTransform(cell_mm_));
    const auto cube = [&](const Vec3& mm) -> Vec3i { return (mm / (kFirst * cell_mm_)).array().floor().cast<int>(); };
    for_each_voxel(cube(box_mm.min()), cube(box_mm.max()),
                   [&](const Vec3i& at) { sample(vdb_coord(kFirst * at), kFirst, distance_.accessor(), nullptr); });
    for_each_leaf(*grid_, [&](Leaf& leaf) { sample(leaf.origin(), Leaf::DIM, distance_.accessor(), &leaf); });
    return extract_surface(*grid_, kClosing_mm);
  }

 private:
  /// Samples a cube of cells: without `leaf`, down to leaves.
  void sample(const openvdb::Coord& first, int side, const openvdb::FloatGrid::ConstAccessor& field, Leaf* leaf) {
    const auto cube = openvdb::CoordBBox::createCube(first, side);
    const Vec3d centre = cell_mm_ * (first.asVec3d() + Vec3d(0.5 * (side - 1)));
    const double centre_mm = distance_.at({centre.x(), centre.y(), centre.z()}, field);
    // Beyond this distance of the centre no cell of the cube is beside the surface.
    const double away_mm = (0.5 * (side - 1) + 1) * std::numbers::sqrt3 * cell_mm_;
    if (side == 1 || std::abs(centre_mm - kClosing_mm) > away_mm) {
      if (leaf != nullptr) leaf->fill(cube, static_cast<float>(centre_mm));
      if (leaf == nullptr && centre_mm < kClosing_mm) grid_->fill(cube, 0.0F, false);  // else it keeps the background
    } else if (side == Leaf::DIM && leaf == nullptr) {
      grid_->tree().touchLeaf(first)->setValuesOn();
    } else {
      const int half = side / 2;
      for (int i = 0; i < 8; ++i) {
        sample(first.offsetBy(half * (i >> 2), half * (i >> 1 & 1), half * (i & 1)), half, field, leaf);
      }
    }
  }

  const SurfaceDistance& distance_;
  double cell_mm_;
  openvdb::FloatGrid::Ptr grid_ = make_float_grid(static_cast<float>(2 * kClosing_mm));
};

/// Was at least half of this bone voxel removed?
bool removed(const BoneView& bone, const Vec3i& voxel) {
  return bone.voxmap.is_bone(voxel) && 2 * bone.fill.get(voxel) < bone.fill_before.get(voxel);
}

/// Calls visit(coord) for the bricks in which material was removed from any voxel.
template <class Visit>
void for_each_reamed_brick(const BoneView& bone, const Visit& visit) {
  bone.fill.for_each_brick([&](const Vec3i& coord, const FillBricks::Brick& fill) {
    const FillBricks::Brick* before = bone.fill_before.brick(coord);
    for (std::size_t i = 0; i < fill.size(); ++i) {
      if (fill[i] < (before == nullptr ? FillBricks::kWhole : (*before)[i])) return visit(coord);
    }
  });
}

/// Marks the points of the offset surface in a box below which bone was removed.
std::vector<std::uint8_t> above_removed_bone(const IsoSurface& offset, const Eigen::AlignedBox3d& box_mm,
                                             const SurfaceDistance& distance, const BoneView& bone) {
  const double voxel_mm = bone.voxmap.grid.voxel_mm;
  std::vector<std::uint8_t> marked(offset.points.size(), 0);
  parallel_items(marked.size(), [&](std::size_t i) {
    const Vec3 p = offset.points[i].cast<double>();
    if (!box_mm.contains(p)) return;  // further out, the distance is not that of all surfaces
    const Vec3 surface = distance.closest_point(p);
    const Vec3 below = (surface + 0.75 * voxel_mm * (surface - p).normalized()) / voxel_mm;
    marked[i] = removed(bone, below.array().round().cast<int>()) ? 1 : 0;
  });
  return marked;
}

/// Dilates the marks over the mouths of closed holes, under which there was no bone to remove.
void dilate(std::vector<std::uint8_t>& marked, const Neighbours& neighbours, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    std::vector<std::uint8_t> wider = marked;
    for (std::size_t i = 0; i < marked.size(); ++i) {
      if (marked[i] == 0) continue;
      for (const std::uint32_t other : neighbours.of(i)) wider[other] = 1;
    }
    marked.swap(wider);
  }
}

/// A grid whose active cells cover every changed brick, plus a margin for interpolation.
openvdb::FloatGrid::Ptr cells_of_changed_bricks(const BoneView& bone, double cell_mm) {
  auto grid = make_float_grid(0.0F);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(cell_mm));
  const double brick_cells = FillBricks::kSide * bone.voxmap.grid.voxel_mm / cell_mm;
  for_each_reamed_brick(bone, [&](const Vec3i& coord) {
    const Vec3d lower = brick_cells * vdb_point(coord);
    const openvdb::Coord from = openvdb::Coord::floor(lower - Vec3d(2));
    const openvdb::Coord to = openvdb::Coord::ceil(lower + Vec3d(brick_cells + 2));
    grid->denseFill(openvdb::CoordBBox(from, to), 0.0F, true);
  });
  return grid;
}

/// Where the offset surface may affect a depth, in the space of voxel indices times voxel_mm: around the bricks that
/// changed, and at most `beside_mm` outside the bounding box of the surface.
Eigen::AlignedBox3d box_of_sources(const UnreamedSurface& unreamed, const BoneView& bone, double cell_mm,
                                   const Vec3& beside_mm) {
  const double voxel_mm = bone.voxmap.grid.voxel_mm, brick_mm = FillBricks::kSide * voxel_mm;
  // A source lies above removed bone, or up to 2·kClosing_mm / cell_mm edges of at most two cells beside such a point.
  const Vec3 reach_mm = Vec3::Constant(5 * kClosing_mm + 6 * cell_mm);
  Eigen::AlignedBox3d box_mm, surface_mm;
  for_each_reamed_brick(bone, [&](const Vec3i& coord) {
    box_mm.extend(brick_mm * coord.cast<double>() - reach_mm);
    box_mm.extend(brick_mm * (coord + Vec3i::Ones()).cast<double>() + reach_mm);
  });
  for (const Eigen::Vector3f& p : unreamed.surface.points) surface_mm.extend(voxel_mm * p.cast<double>());
  if (surface_mm.isEmpty()) return surface_mm;  // less than a voxel of bone
  return box_mm.intersection({surface_mm.min() - beside_mm, surface_mm.max() + beside_mm});
}

openvdb::FloatGrid::Ptr depth_grid(const UnreamedSurface& unreamed, const BoneView& bone) {
  const VoxelGrid& grid = bone.voxmap.grid;
  const double bone_mm3 = static_cast<double>(bone.voxmap.grade.count()) * grid.voxel_mm3();
  const double cell_mm = std::max(grid.voxel_mm, std::cbrt(bone_mm3 / kInteriorCells));
  auto depth = cells_of_changed_bricks(bone, cell_mm);
  if (depth->empty()) return depth;
  const Vec3 beside_mm = Vec3::Constant(kClosing_mm + 3 * cell_mm);  // of what is sampled
  const Eigen::AlignedBox3d box_mm = box_of_sources(unreamed, bone, cell_mm, beside_mm);
  if (box_mm.isEmpty()) return depth;
  const SurfaceDistance distance(unreamed, grid.voxel_mm, {box_mm.min() - beside_mm, box_mm.max() + beside_mm});
  if (distance.empty()) return depth;
  const IsoSurface offset = OffsetSampler(distance, cell_mm).sample_box(box_mm);
  const Vec3 cell = Vec3::Constant(cell_mm);  // where the box ends inside the bone, its faces are surfaces
  const Eigen::AlignedBox3d inner_mm(box_mm.min() + cell, box_mm.max() - cell);
  std::vector<std::uint8_t> marked = above_removed_bone(offset, inner_mm, distance, bone);
  dilate(marked, {offset.points.size(), offset.indices}, static_cast<int>(std::ceil(2 * kClosing_mm / cell_mm)));
  std::vector<Vec3> sources;
  for (std::size_t i = 0; i < marked.size(); ++i) {
    if (marked[i] != 0) sources.push_back(offset.points[i].cast<double>());
  }
  if (sources.empty()) return depth;
  // Sources are a cell apart and at least kClosing_mm away, so the nearest one approximates the nearest triangle.
  const NearestPoint nearest(sources);
  depth->tree().voxelizeActiveTiles();
  for_each_leaf(*depth, [&](Leaf& leaf) {
    for (auto value = leaf.beginValueOn(); value; ++value) {
      const Vec3d mm = depth->indexToWorld(value.getCoord());
      value.setValue(static_cast<float>(nearest({mm.x(), mm.y(), mm.z()}).distance - kClosing_mm));
    }
  });
  return depth;
}

/// The greatest depth, from pairs of neighbouring voxels of which one was removed: the surface lies above the centre of
/// the remaining one by (its fill − ½) voxels, or, if that one is whole, by (½ + fill of the removed one) voxels.
double max_depth_mm(const openvdb::FloatGrid& depth, const BoneView& bone) {
  const double voxel_mm = bone.voxmap.grid.voxel_mm;
  const auto depths = depth.getConstAccessor();
  const auto fraction = [&](const Vec3i& voxel) { return double{1} * bone.fill.get(voxel) / FillBricks::kWhole; };
  double deepest_mm = 0;
  const auto measure = [&](const Vec3i& cut, const Vec3i& kept) {
    if (!bone.voxmap.is_bone(kept) || fraction(kept) < 0.5) return;
    const double above_voxels = fraction(kept) < 1 ? fraction(kept) - 0.5 : 0.5 + fraction(cut);
    const Vec3d mm = voxel_mm * vdb_point(kept);
    const double depth_mm = sample(depths, depth.worldToIndex(mm));
    deepest_mm = std::max(deepest_mm, depth_mm - above_voxels * voxel_mm);
  };
  for_each_reamed_brick(bone, [&](const Vec3i& coord) {
    for (int offset = 0; offset < BrickLattice::kVoxels; ++offset) {
      const Vec3i voxel = BrickLattice::voxel_at(coord, offset);
      if (!removed(bone, voxel)) continue;
      for (int axis = 0; axis < 3; ++axis) {
        measure(voxel, voxel + Vec3i::Unit(axis));
        measure(voxel, voxel - Vec3i::Unit(axis));
      }
    }
  });
  return deepest_mm;
}

}  // namespace

UnreamedSurface::UnreamedSurface(const Voxmap& voxmap, FillBricks fill_before, const FillBricks& after)
    : before(std::move(fill_before)),
      field(Occupancy(voxmap, before)),
      surface(extract_surface(*field.grid().vdb, 0)),
      depth(new ScalarGrid{depth_grid(*this, {voxmap, after, before})}),
      deepest_mm(max_depth_mm(*depth->vdb, {voxmap, after, before})) {}

LayerBoundary::LayerBoundary(const Voxmap& voxmap, const UnreamedSurface& unreamed, const Vec3& a, const Vec3& b,
                             const Vec3& c)
    : voxmap_(voxmap) {
  constexpr double kMargin_voxels = 3;
  const Vec3 normal = (b - a).cross(c - a).normalized();
  const double reach = voxmap.layers->cortical_mm / voxmap.grid.voxel_mm + kMargin_voxels;
  std::vector<Vec3> points;
  for (const Eigen::Vector3f& p : unreamed.surface.points) {
    if (std::abs(normal.dot(p.cast<double>() - a)) < reach) points.emplace_back(p.cast<double>());
  }
  if (points.empty()) return;
  from_surface_ = [nearest = NearestPoint(points)](const Vec3& point) { return nearest(point).distance; };
}

bool LayerBoundary::near(const Vec3& point) const {
  const Vec3i base = point.array().floor().cast<int>();
  int least = UINT8_MAX, most = 0;
  for_each_voxel(base, base + Vec3i::Ones(), [&](const Vec3i& voxel) {
    const int grade = voxmap_.grid.contains(voxel) ? voxmap_.grade.get(voxel) : 0;
    if (grade > 0) least = std::min(least, grade);
    most = std::max(most, grade);
  });
  return least < most;
}

double LayerBoundary::density_at(const Vec3& point, double blend_voxels) const {
  const BoneLayers& layers = *voxmap_.layers;
  if (!from_surface_) return layers.trabecular_g_cm3;
  const double beyond = from_surface_(point) - layers.cortical_mm / voxmap_.grid.voxel_mm;
  const double trabecular = std::clamp(beyond / blend_voxels + 0.5, 0.0, 1.0);
  return layers.cortical_g_cm3 + trabecular * (layers.trabecular_g_cm3 - layers.cortical_g_cm3);
}

}  // namespace reamsim
