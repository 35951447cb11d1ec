#include <openvdb/openvdb.h>

#include <functional>

#include "sim/base/error.h"
#include "sim/bone/bone_vdb.h"
#include "sim/bone/bone_vdb_keys.h"
#include "sim/bone/surface_grid.h"
#include "sim/bone/vdb_archive.h"

namespace reamsim {

namespace {

using Leaf = openvdb::FloatTree::LeafNodeType;
constexpr int kSide = FillBricks::kSide;

/// The value of a voxel with bone: (dense index, voxel).
using VoxelValue = std::function<float(std::size_t, const Vec3i&)>;

/// Fills a leaf with the active voxels of one brick; false when it has none.
bool fill_leaf(Leaf& leaf, const Voxmap& voxmap, const Vec3i& first, const VoxelValue& value) {
  const Vec3i last = (first + Vec3i::Constant(kSide)).cwiseMin(voxmap.grid.dims);
  bool any = false;
  for (int z = first.z(); z < last.z(); ++z) {
    for (int y = first.y(); y < last.y(); ++y) {
      auto index = static_cast<std::size_t>(voxmap.grid.index(first.x(), y, z));
      for (int x = first.x(); x < last.x(); ++x, ++index) {
        if (voxmap.grade[index] == 0) continue;
        leaf.setValueOn(Leaf::coordToOffset({x, y, z}), value(index, {x, y, z}));
        any = true;
      }
    }
  }
  return any;
}

/// A fog volume whose active voxels are those with grade ≠ 0. Bricks and leaves are the same blocks.
openvdb::FloatGrid::Ptr fog(const Voxmap& voxmap, const VoxelValue& value) {
  auto grid = openvdb::FloatGrid::create(0.0F);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  const Vec3i& dims = voxmap.grid.dims;
  auto leaf = std::make_unique<Leaf>();
  for (int z = 0; z < dims.z(); z += kSide) {
    for (int y = 0; y < dims.y(); y += kSide) {
      for (int x = 0; x < dims.x(); x += kSide) {
        leaf = std::make_unique<Leaf>(openvdb::Coord(x, y, z), 0.0F, false);
        if (fill_leaf(*leaf, voxmap, {x, y, z}, value)) grid->tree().addLeaf(leaf.release());
      }
    }
  }
  return grid;
}

openvdb::FloatGrid::Ptr density_grid(const Voxmap& voxmap) {
  return fog(voxmap, [&voxmap](std::size_t index, const Vec3i&) {
    return static_cast<float>(DensityMapping::density_from_grade(voxmap.grade[index]));
  });
}

openvdb::FloatGrid::Ptr fill_grid(const Voxmap& voxmap) {
  return fog(voxmap, [&voxmap](std::size_t, const Vec3i& voxel) {
    return static_cast<float>(voxmap.fill.get(voxel)) / FillBricks::kWhole;
  });
}

openvdb::FloatGrid::Ptr removed_grid(const Voxmap& voxmap, const RemovedFrames& removed) {
  auto grid = openvdb::FloatGrid::create(-1.0F);
  auto write = grid->getAccessor();
  for (const auto& [index, frame] : removed) {
    const Vec3i voxel = voxmap.grid.coord(index);
    write.setValueOn({voxel.x(), voxel.y(), voxel.z()}, static_cast<float>(frame));
  }
  return grid;
}

openvdb::MetaMap bone_metadata(const Voxmap& voxmap, const Metadata& extra) {
  openvdb::MetaMap out;
  for (const auto& [name, value] : extra) {
    if (!name.empty()) out.insertMeta(name, openvdb::StringMetadata(value));
  }
  const auto set = [&out](const char* name, const openvdb::Metadata& value) {
    out.removeMeta(name);  // whatever its type, ours is what the reader relies on
    out.insertMeta(name, value);
  };
  const VoxelGrid& grid = voxmap.grid;
  const Vec3& origin = grid.origin_mm;
  set(vdb_keys::kCreator, openvdb::StringMetadata("reamsim " REAMSIM_VERSION));
  set(vdb_keys::kFrame, openvdb::StringMetadata(voxmap.frame));
  set(vdb_keys::kLengthUnit, openvdb::StringMetadata("mm"));
  set(vdb_keys::kDims, openvdb::Vec3IMetadata({grid.dims.x(), grid.dims.y(), grid.dims.z()}));
  set(vdb_keys::kOrigin, openvdb::Vec3DMetadata({origin.x(), origin.y(), origin.z()}));
  set(vdb_keys::kVoxel, openvdb::DoubleMetadata(grid.voxel_mm));
  set(vdb_keys::kAshSlope, openvdb::DoubleMetadata(voxmap.mapping.ash_slope_g_cm3_per_hu));
  set(vdb_keys::kAshOffset, openvdb::DoubleMetadata(voxmap.mapping.ash_offset_g_cm3));
  set(vdb_keys::kAshFraction, openvdb::DoubleMetadata(voxmap.mapping.ash_fraction));
  return out;
}

void label(openvdb::FloatGrid& grid, const char* name, const char* unit, const openvdb::MetaMap& metadata,
           const Voxmap& voxmap) {
  for (auto entry = metadata.beginMeta(); entry != metadata.endMeta(); ++entry) {
    if (!grid[entry->first]) grid.insertMeta(entry->first, *entry->second);
  }
  grid.setName(name);
  grid.setCreator("reamsim " REAMSIM_VERSION);
  grid.setTransform(index_transform(voxmap.grid));
  grid.insertMeta(vdb_keys::kUnit, openvdb::StringMetadata(unit));
}

}  // namespace

void write_bone_vdb(const std::string& path, const Voxmap& voxmap, const RemovedFrames& removed,
                    const Metadata& metadata) {
  openvdb::initialize();
  try {
    const openvdb::MetaMap common = bone_metadata(voxmap, metadata);
    openvdb::GridCPtrVec grids;
    const auto add = [&](const openvdb::FloatGrid::Ptr& grid, const char* name, const char* unit) {
      label(*grid, name, unit, common, voxmap);
      grids.push_back(grid);
    };
    add(density_grid(voxmap), vdb_keys::kDensity, "g/cm^3");
    add(fill_grid(voxmap), vdb_keys::kFill, "1");
    add(surface_level_set(voxmap), vdb_keys::kSurface, "mm");
    add(removed_grid(voxmap, removed), vdb_keys::kRemovedFrame, "frame index");
    write_vdb_file(path, grids, common);
  } catch (const std::bad_alloc&) {
    throw RunError(path + ": cannot be written (not enough memory for its grids)");
  } catch (const openvdb::Exception&) {
    throw RunError(path + ": cannot be written (OpenVDB refuses its grids or metadata)");
  }
}

}  // namespace reamsim
