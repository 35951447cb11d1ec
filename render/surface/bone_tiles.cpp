#include "render/surface/bone_tiles.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "render/surface/scalar_grid.h"
#include "sim/base/parallel.h"
#include "sim/bone/vdb/vdb_grid.h"

namespace reamsim {
namespace {

constexpr int kSide = FillBricks::kSide;
constexpr int kTileVoxels = BoneTiles::kSideBricks * kSide;
static_assert(kAttributeReach + 2 <= kSide, "one brick round a tile has to hold all that moves the tile's vertices");
/// From a voxel that changes to a vertex that does: three voxels through the field, as many through the gradient, and
/// what smoothing passes on.
constexpr int kChangeReach_bricks = 2;

openvdb::Coord to_coord(const Vec3i& v) {
  return {v.x(), v.y(), v.z()};
}

/// Lowest voxel of a tile.
Vec3i lowest(const Vec3i& tile) {
  return tile * kTileVoxels - Vec3i::Constant(kSide);
}

/// A tile's part of the field, and a brick round it.
openvdb::FloatGrid::Ptr part_of(const openvdb::FloatGrid& field, const Vec3i& lower) {
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

/// The cells in which part_of() has the same surface as the whole field.
openvdb::BoolGrid::Ptr cells_of(const Vec3i& lower) {
  auto cells = make_bool_grid(false);
  const Vec3i first = lower - Vec3i::Constant(kSide - 1);
  const Vec3i last = lower + Vec3i::Constant(kTileVoxels + kSide - 2);
  cells->denseFill({to_coord(first), to_coord(last)}, true, true);
  return cells;
}

/// Which tile a triangle belongs to: the one with the lowest cell of its corners, whichever tile asks.
bool owns(const Vec3i& lower, const IsoSurface& iso, std::size_t triangle) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = [&](std::size_t corner) { return iso.points[iso.indices[3 * triangle + corner]][axis]; };
    const float least = std::min({at(0), at(1), at(2)});
    const int cell = static_cast<int>(std::floor(least));
    if (cell < lower[axis] || cell >= lower[axis] + kTileVoxels) return false;
  }
  return true;
}

/// The triangles of `all` for which `kept` holds, and their vertices alone.
BoneSurface keep(const BoneSurface& all, const std::vector<bool>& kept) {
  constexpr std::uint32_t kNone = ~0U;
  constexpr std::size_t kStride = BoneSurface::kStride;
  BoneSurface out;
  std::vector<std::uint32_t> places(all.vertices.size() / kStride, kNone);
  for (std::size_t triangle = 0; triangle < kept.size(); ++triangle) {
    if (!kept[triangle]) continue;
    for (std::size_t i = 3 * triangle; i < 3 * triangle + 3; ++i) {
      std::uint32_t& place = places[all.indices[i]];
      if (place == kNone) {
        place = static_cast<std::uint32_t>(out.vertices.size() / kStride);
        const auto from = all.vertices.begin() + static_cast<std::ptrdiff_t>(kStride * all.indices[i]);
        out.vertices.insert(out.vertices.end(), from, from + kStride);
      }
      out.indices.push_back(place);
    }
  }
  return out;
}

}  // namespace

BoneTiles::BoneTiles(const BoneFields& fields) {
  const Vec3i bricks = (fields.voxmap.grid.dims.array() + kSide - 1) / kSide;
  tiles_ = (bricks.array() + 2 + kSideBricks - 1) / kSideBricks;
  surfaces_.resize(static_cast<std::size_t>(std::int64_t{1} * tiles_.x() * tiles_.y() * tiles_.z()));
  parallel_items(surfaces_.size(), [&](std::size_t tile) { surfaces_[tile] = mesh(fields, tile); });
}

Vec3i BoneTiles::coord_of(std::size_t tile) const {
  const auto i = static_cast<std::int64_t>(tile);
  const std::int64_t row = i / tiles_.x();
  return {static_cast<int>(i % tiles_.x()), static_cast<int>(row % tiles_.y()), static_cast<int>(row / tiles_.y())};
}

std::vector<bool> BoneTiles::tiles_within(const std::vector<Vec3i>& bricks, int reach) const {
  std::vector<bool> near(surfaces_.size(), false);
  for (const Vec3i& brick : bricks) {
    const Vec3i low = ((brick.array() + 1 - reach).max(0)) / kSideBricks;
    const Vec3i high = ((brick.array() + 1 + reach) / kSideBricks).min(tiles_.array() - 1);
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) {
          near[static_cast<std::size_t>(x + std::int64_t{tiles_.x()} * (y + std::int64_t{tiles_.y()} * z))] = true;
        }
      }
    }
  }
  return near;
}

BoneSurface BoneTiles::mesh(const BoneFields& fields, std::size_t tile) const {
  const Vec3i lower = lowest(coord_of(tile));
  const openvdb::FloatGrid::Ptr part = part_of(*fields.solid.grid().vdb, lower);
  if (part->tree().leafCount() == 0) return {};
  const IsoSurface iso = extract_surface(*part, 0, cells_of(lower));
  std::vector<bool> owned(iso.indices.size() / 3);
  for (std::size_t i = 0; i < owned.size(); ++i) owned[i] = owns(lower, iso, i);
  if (std::find(owned.begin(), owned.end(), true) == owned.end()) return {};
  BoneSurface out = keep(add_vertex_attributes(iso, fields), owned);
  add_density_and_ambient(fields, out);
  return out;
}

std::vector<std::size_t> BoneTiles::update(const BoneFields& fields, const std::vector<Vec3i>& bricks) {
  const int light_bricks = static_cast<int>(std::ceil(fields.ambient.reach_voxels() / kSide));
  const std::vector<bool> changed = tiles_within(bricks, kChangeReach_bricks);
  const std::vector<bool> lit = tiles_within(bricks, light_bricks);
  std::vector<std::size_t> out;
  for (std::size_t tile = 0; tile < surfaces_.size(); ++tile) {
    if (changed[tile] || (lit[tile] && !surfaces_[tile].indices.empty())) out.push_back(tile);
  }
  parallel_items(out.size(), [&](std::size_t i) {
    const std::size_t tile = out[i];
    if (changed[tile]) {
      surfaces_[tile] = mesh(fields, tile);
    } else {
      update_ambient(fields, surfaces_[tile]);
    }
  });
  return out;
}

double BoneTiles::deepest_mm() const {
  double deepest = 0;
  for (const BoneSurface& surface : surfaces_) deepest = std::max(deepest, surface.deepest_mm);
  return deepest;
}

}  // namespace reamsim
