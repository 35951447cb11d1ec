// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/surface/bone_surface.h"

#include <meshoptimizer.h>
#include <array>
#include <cmath>
#include <utility>

#include "render/surface/scalar_grid.h"
#include "sim/base/parallel.h"
#include "sim/bone/vdb/grids.h"

namespace reamsim {
namespace {

constexpr int kSide = FillBricks::kSide;

using Accessor = openvdb::FloatGrid::ConstAccessor;
using openvdb::Vec3d;

constexpr std::size_t kGrain = 2048;
constexpr int kNormalRounds = 4;
constexpr float kDensityDepth_voxels = 1.2F;
constexpr int kPointRounds = 2;
/// The number of edges over which a vertex affects others.
constexpr int kAttributeReach = kNormalRounds + kPointRounds;
constexpr float kMaxDisplacement_voxels = 0.4F;
constexpr int kDepthRounds = 4;           // smooth the voxel steps of the depth
constexpr float kCertainlyReamed = 0.6F;  // below: the edge of the reamed face
constexpr int kEdgeRounds = 2;            // smooth the edge of the reamed face where whole voxels are removed

/// Outward normal: the field's gradient over a step wide enough to average out voxel steps.
Eigen::Vector3f normal_at(const Accessor& field, const Vec3d& p) {
  const Vec3d slope = central_difference([&](const Vec3d& at) { return sample(field, at); }, p, 1.6);
  const double length = slope.length();
  if (length < 1e-9) return Eigen::Vector3f::UnitZ();
  return Eigen::Vector3d(slope.x() / length, slope.y() / length, slope.z() / length).cast<float>();
}

std::vector<Eigen::Vector3f> normals_at(const std::vector<Eigen::Vector3f>& points, const SolidField& field) {
  std::vector<Eigen::Vector3f> normals(points.size());
  parallel_ranges(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    const Accessor now = field.grid().vdb->getConstAccessor();
    for (std::size_t i = begin; i < end; ++i) normals[i] = normal_at(now, vdb_point(points[i]));
  });
  return normals;
}

/// Calls action(the floats of a vertex, its position in voxel index space).
template <class Action>
void for_each_vertex(const VoxelGrid& grid, BoneSurface& surface, const Action& action) {
  parallel_items(surface.count(), kGrain, [&](std::size_t i) {
    float* v = surface.vertices.data() + i * BoneSurface::kStride;
    const Vec3 mm = Eigen::Map<const Eigen::Vector3f>{v}.cast<double>();
    const Eigen::Vector3f point =
        ((mm - grid.origin_mm) / grid.voxel_mm).cast<float>() - Eigen::Vector3f::Constant(0.5F);
    action(v, point);
  });
}

/// Moves the vertices of `iso` by up to 0.4 voxel until they fit their normals, and adds normals, and, in `where`
/// (voxel index space), depth and reaming.
BoneSurface add_vertex_attributes(const IsoSurface& iso, const BoneFields& fields, const Eigen::AlignedBox3f& where) {
  const VoxelGrid& grid = fields.voxmap.grid;
  BoneSurface out;
  out.indices = iso.indices;
  std::vector<Eigen::Vector3f> points = iso.points;
  std::vector<Eigen::Vector3f> normals = normals_at(iso.points, fields.solid);
  const Neighbours neighbours(points.size(), out.indices);
  smooth_normals(neighbours, normals, kNormalRounds);
  fit_to_normals(neighbours, normals, points, kPointRounds, kMaxDisplacement_voxels);
  // Removal is read on the surface: the fitted vertices lie beside it by a part of a voxel.
  const auto removal_at = [&](const ReamingSampler& sampler, std::size_t i) {
    const Vec3d p = vdb_point(points[i]);
    return where.contains(iso.points[i]) && sampler.removed(p) > 0 ? sampler.removal(sampler.on_surface(p)) : Removal();
  };
  Reaming reaming = reaming_at(points.size(), fields.unreamed, fields.solid.grid(), removal_at, [&](std::size_t i) {
    return vdb_point(Eigen::Vector3f(points[i] * static_cast<float>(grid.voxel_mm)));
  });
  reaming.smooth(neighbours, points, kDepthRounds, kEdgeRounds);
  out.vertices.resize(points.size() * BoneSurface::kStride);
  parallel_items(points.size(), kGrain, [&](std::size_t i) {
    const Vec3 mm = grid.origin_mm + grid.voxel_mm * (points[i].cast<double>() + Vec3::Constant(0.5));
    float* v = out.vertices.data() + i * BoneSurface::kStride;
    Eigen::Map<Eigen::Vector3f>{v} = mm.cast<float>();
    Eigen::Map<Eigen::Vector3f>{v + BoneSurface::kNormal} = normals[i];
    v[BoneSurface::kDepth] = reaming.depth_mm[i];
    v[BoneSurface::kReamed] = reaming.reamed[i];
  });
  return out;
}

/// Adds what does not depend on neighbours: density and ambient accessibility, and the greatest depth.
void add_density_and_ambient(const BoneFields& fields, BoneSurface& surface) {
  for_each_vertex(fields.voxmap.grid, surface, [&](float* v, const Eigen::Vector3f& point) {
    const Eigen::Map<const Eigen::Vector3f> normal(v + BoneSurface::kNormal);
    const Eigen::Vector3f below = point - kDensityDepth_voxels * normal;
    v[BoneSurface::kDensity] = mean_density<float>(fields.voxmap, below, [](const Vec3i&) { return 1.0F; });
    v[BoneSurface::kAccessibility] = fields.ambient.accessibility(point, normal);
  });
  surface.deepest_mm = 0;
  const VoxelGrid& grid = fields.voxmap.grid;
  const Vec3 first_center = grid.origin_mm + Vec3::Constant(0.5 * grid.voxel_mm);
  const ReamingSampler sampler(fields.unreamed, fields.solid.grid());
  for (std::size_t i = 0; i < surface.vertices.size(); i += BoneSurface::kStride) {
    const float* v = surface.vertices.data() + i;
    if (v[BoneSurface::kReamed] <= kCertainlyReamed) continue;
    const Eigen::Vector3f point_mm = (Eigen::Map<const Eigen::Vector3f>{v}.cast<double>() - first_center).cast<float>();
    surface.deepest_mm = std::max(surface.deepest_mm, double{sampler.depth_mm(vdb_point(point_mm))});
  }
}

void update_ambient(const BoneFields& fields, BoneSurface& surface) {
  for_each_vertex(fields.voxmap.grid, surface, [&](float* v, const Eigen::Vector3f& point) {
    v[BoneSurface::kAccessibility] =
        fields.ambient.accessibility(point, Eigen::Map<const Eigen::Vector3f>{v + BoneSurface::kNormal});
  });
}

constexpr int kTileVoxels = BoneTiles::kSideBricks * kSide;
static_assert(kAttributeReach + 2 <= kSide, "the one-brick halo of a tile must contain all that affects its vertices");
/// How far a changed voxel affects vertices: three voxels each by field and gradient, the rest by smoothing.
constexpr int kChangeReach_bricks = 2;

/// The first voxel of a tile.
Vec3i lower_of(const Vec3i& tile) {
  return tile * kTileVoxels - Vec3i::Constant(kSide);
}

/// The cells in which the bricks of `voxels` with a one-brick halo have the same surface as the whole field.
openvdb::BoolGrid::Ptr cells_of(const VoxelBox& voxels) {
  auto cells = make_bool_grid(false);
  const Vec3i first = voxels.first - Vec3i::Constant(kSide - 1), last = voxels.last + Vec3i::Constant(kSide - 1);
  cells->denseFill({vdb_coord(first), vdb_coord(last)}, true, true);
  return cells;
}

/// The tile of a triangle. The lowest cell of its corners decides, so that all agree.
Vec3i owner_of(const IsoSurface& iso, std::size_t triangle) {
  const auto at = [&](std::size_t corner) { return iso.points[iso.indices[3 * triangle + corner]].array(); };
  return (at(0).min(at(1)).min(at(2)).floor().cast<int>() + kSide + kTileVoxels) / kTileVoxels - 1;
}

/// The triangles of `all` whose owner is `tile`, and only their vertices, in the order of their first use.
BoneSurface extract_owned(const BoneSurface& all, const std::vector<Vec3i>& owners, const Vec3i& tile) {
  BoneSurface out;
  for (std::size_t i = 0; i < all.indices.size(); ++i) {
    if (owners[i / 3] == tile) out.indices.push_back(all.indices[i]);
  }
  if (out.indices.empty()) return out;
  out.vertices.resize(all.vertices.size());
  constexpr std::size_t kStride = BoneSurface::kStride;
  out.vertices.resize(kStride * meshopt_optimizeVertexFetch(out.vertices.data(), out.indices.data(), out.indices.size(),
                                                            all.vertices.data(), all.count(), kStride * sizeof(float)));
  out.vertices.shrink_to_fit();  // without the room for the others
  return out;
}

}  // namespace

BoneFields::BoneFields(const Voxmap& bone, FillBricks fill_now, const UnreamedSurface& unreamed_surface)
    : voxmap(bone),
      fill(std::move(fill_now)),
      unreamed(unreamed_surface),
      occupancy(voxmap, fill),
      solid(occupancy),
      ambient(occupancy) {
  fill.take_changed();
}

std::vector<Vec3i> BoneFields::update() {
  std::vector<Vec3i> bricks = fill.take_changed();
  occupancy.update(bricks);
  solid.update(occupancy, bricks);
  ambient.update(occupancy, bricks);
  return bricks;
}

BoneTiles::BoneTiles(const BoneFields& fields) {
  const Vec3i bricks = (fields.voxmap.grid.dims.array() + kSide - 1) / kSide;
  tiles_ = {(bricks.array() + 2 + kSideBricks - 1) / kSideBricks};
  surfaces_.resize(tiles_.count(), std::make_shared<BoneSurface>());
  mesh(fields, std::vector<bool>(surfaces_.size(), true));
}

std::vector<bool> BoneTiles::tiles_within(const std::vector<Vec3i>& bricks, int reach) const {
  std::vector<bool> near(surfaces_.size(), false);
  for (const Vec3i& brick : bricks) {
    const Vec3i low = ((brick.array() + 1 - reach).max(0)) / kSideBricks;
    const Vec3i high = ((brick.array() + 1 + reach) / kSideBricks).min(tiles_.dims.array() - 1);
    for_each_voxel(low, high, [&](const Vec3i& tile) { near[tiles_.index(tile)] = true; });
  }
  return near;
}

void BoneTiles::mesh(const BoneFields& fields, const std::vector<bool>& wanted) {
  // Neighbours together, because what lies around them is meshed as well.
  constexpr int kBlockTiles = 3;
  const BrickLattice blocks{(tiles_.dims.array() + kBlockTiles - 1) / kBlockTiles};
  std::vector<std::vector<Vec3i>> parts(blocks.count());
  for (std::size_t tile = 0; tile < wanted.size(); ++tile) {
    if (wanted[tile]) parts[blocks.index(tiles_.coord(tile) / kBlockTiles)].push_back(tiles_.coord(tile));
  }
  std::erase_if(parts, [](const std::vector<Vec3i>& part) { return part.empty(); });
  parallel_items(parts.size(), [&](std::size_t i) { mesh_together(fields, parts[i]); });
}

void BoneTiles::mesh_together(const BoneFields& fields, const std::vector<Vec3i>& tiles) {
  Eigen::AlignedBox3i box;
  for (const Vec3i& tile : tiles) {
    box.extend(tile);
    surfaces_[tiles_.index(tile)] = std::make_shared<BoneSurface>();
  }
  const Vec3i ones = Vec3i::Ones();
  const VoxelBox voxels{lower_of(box.min()), lower_of(box.max() + ones) - ones};
  const openvdb::FloatGrid::Ptr part =
      bricks_of(*fields.solid.grid().vdb, voxels.first / kSide - ones, (voxels.last + ones) / kSide);
  if (part->tree().leafCount() == 0) return;
  const IsoSurface iso = extract_surface(*part, 0, cells_of(voxels));
  std::vector<Vec3i> owners(iso.indices.size() / 3);
  for (std::size_t i = 0; i < owners.size(); ++i) owners[i] = owner_of(iso, i);
  // The vertices that they own, and those whose reaming is smoothed into them.
  const Eigen::AlignedBox3i where(voxels.first - kDepthRounds * ones, voxels.last + (2 + kDepthRounds) * ones);
  const BoneSurface all = add_vertex_attributes(iso, fields, where.cast<float>());
  for (const Vec3i& tile : tiles) {
    BoneSurface own = extract_owned(all, owners, tile);
    add_density_and_ambient(fields, own);
    surfaces_[tiles_.index(tile)] = std::make_shared<BoneSurface>(std::move(own));
  }
}

std::vector<std::size_t> BoneTiles::update(const BoneFields& fields, const std::vector<Vec3i>& bricks) {
  const std::vector<bool> changed = tiles_within(bricks, kChangeReach_bricks);
  const std::vector<bool> lit =
      tiles_within(bricks, static_cast<int>(std::ceil(fields.ambient.reach_voxels() / kSide)));
  std::vector<std::size_t> out;
  for (std::size_t tile = 0; tile < surfaces_.size(); ++tile) {
    if (changed[tile] || (lit[tile] && !surfaces_[tile]->indices.empty())) out.push_back(tile);
  }
  mesh(fields, changed);
  parallel_items(out.size(), [&](std::size_t i) {
    if (changed[out[i]]) return;
    BoneSurface surface = *surfaces_[out[i]];
    update_ambient(fields, surface);
    surfaces_[out[i]] = std::make_shared<BoneSurface>(std::move(surface));
  });
  return out;
}

BoneSurface BoneTiles::whole() const {
  BoneSurface all;
  all.deepest_mm = deepest_mm();
  std::vector<std::array<std::int64_t, 3>> places;
  for (const auto& surface : surfaces_) {
    const BoneSurface& tile = *surface;
    const auto first = static_cast<std::uint32_t>(all.count());
    all.vertices.insert(all.vertices.end(), tile.vertices.begin(), tile.vertices.end());
    for (const std::uint32_t index : tile.indices) all.indices.push_back(first + index);
    for (std::size_t i = 0; i < tile.count(); ++i) {
      const auto micrometres = [&](int axis) { return std::llround(1000 * double{tile.position_mm(i)[axis]}); };
      places.push_back({micrometres(0), micrometres(1), micrometres(2)});
    }
  }
  std::vector<std::uint32_t> remap(all.count());
  constexpr std::size_t kBytes = BoneSurface::kStride * sizeof(float);
  const std::size_t count = meshopt_generateVertexRemap(remap.data(), all.indices.data(), all.indices.size(),
                                                        places.data(), places.size(), sizeof(places[0]));
  meshopt_remapIndexBuffer(all.indices.data(), all.indices.data(), all.indices.size(), remap.data());
  meshopt_remapVertexBuffer(all.vertices.data(), all.vertices.data(), remap.size(), kBytes, remap.data());
  all.vertices.resize(count * BoneSurface::kStride);
  return all;
}

double BoneTiles::deepest_mm() const {
  double out = 0;
  for (const auto& surface : surfaces_) out = std::max(out, surface->deepest_mm);
  return out;
}

}  // namespace reamsim
