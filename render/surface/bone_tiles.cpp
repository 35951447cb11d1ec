// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/surface/bone_surface.h"

#include <algorithm>
#include <cmath>

#include "render/surface/scalar_grid.h"
#include "sim/base/parallel.h"
#include "sim/bone/vdb/grids.h"

namespace reamsim {
namespace {

constexpr int kSide = FillBricks::kSide;
constexpr int kTileVoxels = BoneTiles::kSideBricks * kSide;
static_assert(kAttributeReach + 2 <= kSide, "the one-brick halo of a tile must contain all that affects its vertices");
/// How far a changed voxel affects vertices: three voxels each by field and gradient, the rest by smoothing.
constexpr int kChangeReach_bricks = 2;

openvdb::Coord to_coord(const Vec3i& v) {
  return {v.x(), v.y(), v.z()};
}

/// Lowest voxel of a tile.
Vec3i lowest(const Vec3i& tile) {
  return tile * kTileVoxels - Vec3i::Constant(kSide);
}

/// The field of a tile with a one-brick halo.
openvdb::FloatGrid::Ptr tile_field(const openvdb::FloatGrid& field, const Vec3i& lower) {
  auto part = make_float_grid(field.background());
  auto from = field.getConstAccessor();
  constexpr int kBricks = BoneTiles::kSideBricks + 2;
  for (int i = 0; i < kBricks * kBricks * kBricks; ++i) {
    const Vec3i brick(i % kBricks - 1, i / kBricks % kBricks - 1, i / (kBricks * kBricks) - 1);
    const openvdb::Coord origin = to_coord(lower + kSide * brick);
    if (const auto* leaf = from.probeConstLeaf(origin)) {
      part->tree().addLeaf(new openvdb::FloatTree::LeafNodeType(*leaf));
    } else if (const float value = from.getValue(origin); value != field.background()) {
      part->tree().addTile(1, origin, value, false);
    }
  }
  return part;
}

/// The cells in which tile_field() has the same surface as the whole field.
openvdb::BoolGrid::Ptr cells_of(const Vec3i& lower) {
  auto cells = make_bool_grid(false);
  const Vec3i first = lower - Vec3i::Constant(kSide - 1);
  const Vec3i last = lower + Vec3i::Constant(kTileVoxels + kSide - 2);
  cells->denseFill({to_coord(first), to_coord(last)}, true, true);
  return cells;
}

/// Does a triangle belong to this tile? The lowest cell of its corners decides, so that every tile agrees.
bool owns(const Vec3i& lower, const IsoSurface& iso, std::size_t triangle) {
  const auto at = [&](std::size_t corner) { return iso.points[iso.indices[3 * triangle + corner]].array(); };
  const Eigen::Array3i cell = at(0).min(at(1)).min(at(2)).floor().cast<int>() - lower.array();
  return (cell >= 0).all() && (cell < kTileVoxels).all();
}

/// The triangles of `all` that are `owned`, and only their vertices.
BoneSurface extract_owned(const BoneSurface& all, const std::vector<bool>& owned) {
  constexpr std::uint32_t kNone = ~0U;
  constexpr std::size_t kStride = BoneSurface::kStride;
  BoneSurface out;
  std::vector<std::uint32_t> new_index(all.vertices.size() / kStride, kNone);
  for (std::size_t i = 0; i < all.indices.size(); ++i) {
    if (!owned[i / 3]) continue;
    std::uint32_t& index = new_index[all.indices[i]];
    if (index == kNone) {
      index = static_cast<std::uint32_t>(out.vertices.size() / kStride);
      const auto from = all.vertices.begin() + static_cast<std::ptrdiff_t>(kStride * all.indices[i]);
      out.vertices.insert(out.vertices.end(), from, from + kStride);
    }
    out.indices.push_back(index);
  }
  return out;
}

}  // namespace

BoneTiles::BoneTiles(const BoneFields& fields) {
  const Vec3i bricks = (fields.voxmap.grid.dims.array() + kSide - 1) / kSide;
  tiles_ = {(bricks.array() + 2 + kSideBricks - 1) / kSideBricks};
  surfaces_.resize(tiles_.count());
  parallel_items(surfaces_.size(), [&](std::size_t tile) { surfaces_[tile] = mesh(fields, tile); });
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

BoneSurface BoneTiles::mesh(const BoneFields& fields, std::size_t tile) const {
  const Vec3i lower = lowest(tiles_.coord(tile));
  const openvdb::FloatGrid::Ptr part = tile_field(*fields.solid.grid().vdb, lower);
  if (part->tree().leafCount() == 0) return {};
  const IsoSurface iso = extract_surface(*part, 0, cells_of(lower));
  std::vector<bool> owned(iso.indices.size() / 3);
  for (std::size_t i = 0; i < owned.size(); ++i) owned[i] = owns(lower, iso, i);
  if (std::find(owned.begin(), owned.end(), true) == owned.end()) return {};
  BoneSurface out = extract_owned(add_vertex_attributes(iso, fields), owned);
  add_density_and_ambient(fields, out);
  return out;
}

std::vector<std::size_t> BoneTiles::update(const BoneFields& fields, const std::vector<Vec3i>& bricks) {
  const std::vector<bool> changed = tiles_within(bricks, kChangeReach_bricks);
  const std::vector<bool> lit =
      tiles_within(bricks, static_cast<int>(std::ceil(fields.ambient.reach_voxels() / kSide)));
  std::vector<std::size_t> out;
  for (std::size_t tile = 0; tile < surfaces_.size(); ++tile) {
    if (changed[tile] || (lit[tile] && !surfaces_[tile].indices.empty())) out.push_back(tile);
  }
  parallel_items(out.size(), [&](std::size_t i) {
    const std::size_t tile = out[i];
    if (!changed[tile]) return update_ambient(fields, surfaces_[tile]);
    surfaces_[tile] = mesh(fields, tile);
  });
  return out;
}

double BoneTiles::deepest_mm() const {
  double deepest = 0;
  for (const BoneSurface& surface : surfaces_) deepest = std::max(deepest, surface.deepest_mm);
  return deepest;
}

}  // namespace reamsim
