#include "render/surface/unreamed_surface.h"

#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/ValueTransformer.h>

#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/BVH>
#include <utility>

#include "render/surface/surface_smoothing.h"
#include "sim/bone/vdb/vdb_grid.h"

namespace reamsim {
namespace {

using openvdb::Vec3d;
using Point = Eigen::Vector3d;

/// A point that depth is measured from, as Eigen's tree wants it.
struct Source {
  Point at;
};
Eigen::AlignedBox3d bounding_box(const Source& source) {
  return Eigen::AlignedBox3d(source.at);
}
using SourceTree = Eigen::KdBVH<double, 3, Source>;

/// Is this voxel bone that was reamed away?
bool gone(const Voxmap& voxmap, const FillBricks& last, const FillBricks& before, const Vec3i& voxel) {
  if (!voxmap.grid.contains(voxel)) return false;
  return voxmap.grade.get(voxel) != 0 && 2 * last.get(voxel) < before.get(voxel);
}

/// Has any of this brick's voxels lost something?
bool reamed(const FillBricks::Brick& fill, const FillBricks::Brick* before) {
  for (std::size_t i = 0; i < fill.size(); ++i) {
    if (fill[i] < (before == nullptr ? FillBricks::kWhole : (*before)[i])) return true;
  }
  return false;
}

/// Marks the points of the moved surface below which the bone is gone.
std::vector<std::uint8_t> above_gone_bone(const UnreamedBone& bone, const Voxmap& voxmap, const FillBricks& last) {
  const MovedSurface& moved = bone.moved();
  const double voxel_mm = voxmap.grid.voxel_mm;
  const auto accessor = moved.distance_mm->getConstAccessor();
  const auto distance_at = [&](const Vec3d& mm) {
    return openvdb::tools::BoxSampler::sample(accessor, moved.distance_mm->worldToIndex(mm));
  };
  std::vector<std::uint8_t> marked(moved.surface.points.size(), 0);
  for (std::size_t i = 0; i < marked.size(); ++i) {
    const Vec3d p(moved.surface.points[i]);
    Vec3d slope;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3d step(0.0);
      step[axis] = 0.5 * moved.distance_mm->voxelSize()[0];
      slope[axis] = distance_at(p + step) - distance_at(p - step);
    }
    if (slope.length() < 1e-9) continue;
    const Vec3d below = (p - slope.unit() * (UnreamedBone::kBridge_mm + 0.75 * voxel_mm)) / voxel_mm;
    const Vec3i voxel = Point(below.x(), below.y(), below.z()).array().round().cast<int>();
    marked[i] = gone(voxmap, last, bone.before(), voxel) ? 1 : 0;
  }
  return marked;
}

/// Spreads the marks over the mouths of bridged holes, under which there was no bone to go.
void spread(std::vector<std::uint8_t>& marked, const Neighbours& neighbours, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    std::vector<std::uint8_t> wider = marked;
    for (std::size_t i = 0; i < marked.size(); ++i) {
      if (marked[i] == 0) continue;
      for (const std::uint32_t other : neighbours.of(i)) wider[other] = 1;
    }
    marked.swap(wider);
  }
}

/// For Eigen's tree: the squared distance from `from` to a point, and to a box at least.
struct SquaredDistance {
  using Scalar = double;
  Point from;

  double minimumOnVolume(const SourceTree::Volume& box) const { return box.squaredExteriorDistance(from); }
  double minimumOnObject(const Source& source) const { return (source.at - from).squaredNorm(); }
};

/// An empty grid whose active cells cover every brick that has lost something, and a little more for interpolation.
openvdb::FloatGrid::Ptr cells_of_changed_bricks(double voxel_mm, const FillBricks& last, const FillBricks& before,
                                                double cell_mm) {
  auto grid = make_float_grid(0.0F);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(cell_mm));
  const double brick_cells = FillBricks::kSide * voxel_mm / cell_mm;
  last.for_each_brick([&](const Vec3i& coord, const FillBricks::Brick& fill) {
    if (!reamed(fill, before.brick(coord))) return;
    const Vec3d lower = brick_cells * Vec3d(coord.x(), coord.y(), coord.z());
    const openvdb::Coord from = openvdb::Coord::floor(lower - Vec3d(2));
    const openvdb::Coord to = openvdb::Coord::ceil(lower + Vec3d(brick_cells + 2));
    grid->denseFill(openvdb::CoordBBox(from, to), 0.0F, true);
  });
  return grid;
}

openvdb::FloatGrid::Ptr depth_grid(const UnreamedBone& bone, const Voxmap& voxmap, const FillBricks& last) {
  const MovedSurface& moved = bone.moved();
  auto depth = cells_of_changed_bricks(voxmap.grid.voxel_mm, last, bone.before(), moved.cell_mm);
  if (depth->empty()) return depth;
  std::vector<std::uint8_t> marked = above_gone_bone(bone, voxmap, last);
  spread(marked, {moved.surface.points.size(), flat_indices(moved.surface)},
         static_cast<int>(std::ceil(2 * UnreamedBone::kBridge_mm / moved.cell_mm)));
  std::vector<Source> sources;
  for (std::size_t i = 0; i < marked.size(); ++i) {
    const openvdb::Vec3s& p = moved.surface.points[i];
    if (marked[i] != 0) sources.push_back({Point(p.x(), p.y(), p.z())});
  }
  if (sources.empty()) return depth;
  // Sources stand a cell apart and at least kBridge_mm away, so the nearest of them is as good as the nearest triangle.
  const SourceTree tree(sources.begin(), sources.end());
  const auto measure = [&](const openvdb::FloatGrid::ValueOnIter& value) {
    const Vec3d mm = depth->indexToWorld(value.getCoord());
    SquaredDistance from{Point(mm.x(), mm.y(), mm.z())};
    const double distance_mm = std::sqrt(Eigen::BVMinimize(tree, from));
    value.setValue(static_cast<float>(distance_mm - UnreamedBone::kBridge_mm));
  };
  depth->tree().voxelizeActiveTiles();
  openvdb::tools::foreach (depth->beginValueOn(), measure);
  return depth;
}

/// By the pairs of neighbours of which one's middle is gone and the other's is still bone: the surface passes between
/// them. It is above the latter's middle by (its share left − ½) voxels, or, where that one is whole, by (½ + the
/// other's share) voxels.
double deepest_of(const openvdb::FloatGrid& depth, const Voxmap& voxmap, const FillBricks& last,
                  const FillBricks& before) {
  const double voxel_mm = voxmap.grid.voxel_mm;
  const auto depths = depth.getConstAccessor();
  const auto share = [&](const Vec3i& voxel) { return static_cast<double>(last.get(voxel)) / FillBricks::kWhole; };
  double deepest_mm = 0;
  const auto look_at = [&](const Vec3i& gone_voxel, const Vec3i& kept) {
    if (!voxmap.grid.contains(kept) || voxmap.grade.get(kept) == 0 || share(kept) < 0.5) return;
    const double above_voxels = share(kept) < 1 ? share(kept) - 0.5 : 0.5 + share(gone_voxel);
    const Vec3d mm = voxel_mm * Vec3d(kept.x(), kept.y(), kept.z());
    const double depth_mm = openvdb::tools::BoxSampler::sample(depths, depth.worldToIndex(mm));
    deepest_mm = std::max(deepest_mm, depth_mm - above_voxels * voxel_mm);
  };
  last.for_each_brick([&](const Vec3i& coord, const FillBricks::Brick& fill) {
    if (!reamed(fill, before.brick(coord))) return;
    for (int offset = 0; offset < BrickLattice::kVoxels; ++offset) {
      const Vec3i voxel = BrickLattice::voxel_at(coord, offset);
      if (!gone(voxmap, last, before, voxel)) continue;
      for (int axis = 0; axis < 3; ++axis) {
        look_at(voxel, voxel + Vec3i::Unit(axis));
        look_at(voxel, voxel - Vec3i::Unit(axis));
      }
    }
  });
  return deepest_mm;
}

}  // namespace

UnreamedSurface::UnreamedSurface(std::shared_ptr<const UnreamedBone> bone, const Voxmap& voxmap, const FillBricks& last)
    : bone_(std::move(bone)),
      depth_(depth_grid(*bone_, voxmap, last)),
      deepest_mm_(deepest_of(*depth_, voxmap, last, bone_->before())) {}

UnreamedSurface::UnreamedSurface(const FilledVoxmap& voxmap, FillBricks before)
    : UnreamedSurface(std::make_shared<UnreamedBone>(voxmap, std::move(before)), voxmap, voxmap.fill) {}

}  // namespace reamsim
