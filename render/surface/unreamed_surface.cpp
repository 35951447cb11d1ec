// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/surface/solid_field.h"

#include <algorithm>
#include <boost/pending/disjoint_sets.hpp>
#include <cmath>
#include <cstdint>
#include <optional>
#include <unsupported/Eigen/BVH>
#include <utility>

#include "render/surface/scalar_grid.h"
#include "sim/base/parallel.h"
#include "sim/bone/vdb/grids.h"

namespace reamsim {
namespace {

using openvdb::Vec3d;

/// The distance to the nearest of some points, at least one.
std::function<double(const Vec3&)> distance_to_nearest(const std::vector<Vec3>& points) {
  const std::vector<Eigen::AlignedBox3d> boxes(points.begin(), points.end());
  const auto tree =
      std::make_shared<const Eigen::KdBVH<double, 3, Vec3>>(points.begin(), points.end(), boxes.begin(), boxes.end());
  return [tree](const Vec3& from) {
    /// For Eigen::BVMinimize: the squared distance to a point, and its lower bound in a box.
    struct Query {
      using Scalar = double;
      const Vec3& from;

      double minimumOnVolume(const Eigen::AlignedBox3d& box) const { return box.squaredExteriorDistance(from); }
      double minimumOnObject(const Vec3& point) const { return (point - from).squaredNorm(); }
    } query{from};
    return std::sqrt(Eigen::BVMinimize(*tree, query));
  };
}

/// Depth is not measured from the walls of holes and slits up to twice this wide.
constexpr double kClosing_mm = 1.8;
/// Number of depth cells inside the bone. More cost time without benefit, because a distance varies smoothly.
constexpr double kInteriorCells = 400'000;

/// The surface offset outwards by kClosing_mm, which closes narrow holes (morphological closing).
struct OffsetSurface {
  openvdb::FloatGrid::Ptr distance_mm;  ///< from the surface
  IsoSurface surface;                   ///< in the space of voxel indices times voxel_mm
};

OffsetSurface offset_outwards(const IsoSurface& surface, double voxel_mm, double cell_mm) {
  const auto transform = openvdb::math::Transform::createLinearTransform(cell_mm);
  const double outside_cells = kClosing_mm / cell_mm + 3;
  OffsetSurface out;
  if (surface.indices.empty()) {  // less than a voxel of bone
    out.distance_mm = make_float_grid(static_cast<float>(outside_cells) * static_cast<float>(cell_mm));
    out.distance_mm->setTransform(transform);
    return out;
  }
  SampledMesh in_cells;
  const auto scale = static_cast<float>(voxel_mm / cell_mm);
  for (const Eigen::Vector3f& p : surface.points) in_cells.points.push_back(vdb_point(Eigen::Vector3f(p * scale)));
  for (std::size_t i = 0; i < surface.indices.size(); i += 3) {
    in_cells.triangles.emplace_back(surface.indices.data() + i);
  }
  out.distance_mm = mesh_distance(in_cells, *transform, outside_cells, 1);  // only the outside is used
  out.surface = extract_surface(*out.distance_mm, kClosing_mm);
  return out;
}

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

/// Marks the points of the offset surface below which bone was removed.
std::vector<std::uint8_t> above_removed_bone(const OffsetSurface& offset, const BoneView& bone) {
  const double voxel_mm = bone.voxmap.grid.voxel_mm;
  const auto accessor = offset.distance_mm->getConstAccessor();
  const auto distance_at = [&](const Vec3d& mm) { return sample(accessor, offset.distance_mm->worldToIndex(mm)); };
  std::vector<std::uint8_t> marked(offset.surface.points.size(), 0);
  for (std::size_t i = 0; i < marked.size(); ++i) {
    const Vec3d p = vdb_point(offset.surface.points[i]);
    const Vec3d slope = central_difference(distance_at, p, 0.5 * offset.distance_mm->voxelSize()[0]);
    if (slope.length() < 1e-9) continue;
    const Vec3d below = (p - slope.unit() * (kClosing_mm + 0.75 * voxel_mm)) / voxel_mm;
    const Vec3i voxel = Vec3(below.x(), below.y(), below.z()).array().round().cast<int>();
    marked[i] = removed(bone, voxel) ? 1 : 0;
  }
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

/// Has the bone a closed cavity, whose surface encloses a negative volume?
bool has_cavity(const IsoSurface& surface) {
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
  return std::ranges::any_of(volumes, [](double volume) { return volume < 0; });
}

/// The surface of the unreamed bone wherever it may affect a depth: below the offset surface above removed bone, with
/// the mouths of holes that the marks are dilated over. Flat faces close it beyond. None where that saves little, or
/// where the part might open a cavity, from whose walls no depth is measured.
std::optional<IsoSurface> surface_near_changes(const UnreamedSurface& unreamed, const BoneView& bone, double cell_mm) {
  const double reach_mm = 8 * kClosing_mm + 6 * cell_mm;
  Eigen::AlignedBox3i changed;
  for_each_reamed_brick(bone, [&](const Vec3i& coord) { changed.extend(coord); });
  const double brick_mm = FillBricks::kSide * bone.voxmap.grid.voxel_mm;
  const Vec3i reach = Vec3i::Constant(1 + static_cast<int>(std::ceil(reach_mm / brick_mm)));
  const Vec3i first = (changed.min() - reach).cwiseMax(-1);
  const Vec3i dims = bone.fill.brick_dims(), last = (changed.max() + reach).cwiseMin(dims);
  const double fraction = (last - first).cast<double>().prod() / dims.cast<double>().prod();
  if (fraction > 0.5 || has_cavity(unreamed.surface)) return std::nullopt;
  const openvdb::FloatGrid::Ptr part = bricks_of(*unreamed.field.grid().vdb, first, last);
  // OpenVDB finds no surface between two constant bricks.
  for_each_voxel(first, last, [&](const Vec3i& brick) {
    const bool outer = ((brick - first).array() == 0).any() || ((last - brick).array() == 0).any();
    const openvdb::Coord origin = vdb_coord(FillBricks::kSide * brick);
    if (outer && part->tree().getValue(origin) < 0) part->tree().touchLeaf(origin)->setValuesOn();
  });
  return extract_surface(*part, 0);
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

openvdb::FloatGrid::Ptr depth_grid(const UnreamedSurface& unreamed, const BoneView& bone) {
  const VoxelGrid& grid = bone.voxmap.grid;
  const double bone_mm3 = static_cast<double>(bone.voxmap.grade.count()) * grid.voxel_mm3();
  const double cell_mm = std::max(grid.voxel_mm, std::cbrt(bone_mm3 / kInteriorCells));
  auto depth = cells_of_changed_bricks(bone, cell_mm);
  if (depth->empty()) return depth;
  const std::optional<IsoSurface> part = surface_near_changes(unreamed, bone, cell_mm);
  const OffsetSurface offset = offset_outwards(part ? *part : unreamed.surface, grid.voxel_mm, cell_mm);
  std::vector<std::uint8_t> marked = above_removed_bone(offset, bone);
  dilate(marked, {offset.surface.points.size(), offset.surface.indices},
         static_cast<int>(std::ceil(2 * kClosing_mm / cell_mm)));
  std::vector<Vec3> sources;
  for (std::size_t i = 0; i < marked.size(); ++i) {
    if (marked[i] != 0) sources.push_back(offset.surface.points[i].cast<double>());
  }
  if (sources.empty()) return depth;
  // Sources are a cell apart and at least kClosing_mm away, so the nearest one approximates the nearest triangle.
  const auto distance_to_source = distance_to_nearest(sources);
  depth->tree().voxelizeActiveTiles();
  std::vector<openvdb::FloatTree::LeafNodeType*> leaves;
  depth->tree().getNodes(leaves);
  parallel_items(leaves.size(), [&](std::size_t leaf) {
    for (auto value = leaves[leaf]->beginValueOn(); value; ++value) {
      const Vec3d mm = depth->indexToWorld(value.getCoord());
      value.setValue(static_cast<float>(distance_to_source({mm.x(), mm.y(), mm.z()}) - kClosing_mm));
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
  if (!points.empty()) from_surface_ = distance_to_nearest(points);
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
