// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <openvdb/openvdb.h>

#include <array>
#include <memory>

#include "sim/base/error.h"
#include "sim/base/memory.h"
#include "sim/base/parallel.h"
#include "sim/bone/vdb/bone_vdb.h"
#include "sim/bone/vdb/bone_vdb_metadata.h"
#include "sim/bone/vdb/grids.h"
#include "sim/bone/vdb/surface_grid.h"
#include "sim/bone/vdb/vdb_archive.h"

namespace reamsim {

namespace {

using Leaf = openvdb::FloatTree::LeafNodeType;
static_assert(Leaf::DIM == GradeBricks::kSide);

openvdb::Coord coord_of(const Vec3i& voxel) {
  return {voxel.x(), voxel.y(), voxel.z()};
}

/// Adds a leaf to the tree, as a tile if it is constant, as most leaves inside a bone are.
void put(std::unique_ptr<Leaf> leaf, openvdb::FloatTree& tree) {
  float all = 0;
  bool active = false;
  if (leaf->isConstant(all, active)) {
    tree.addTile(1, leaf->origin(), all, active);
  } else {
    tree.addLeaf(leaf.release());
  }
}

/// A fog volume of `value(grade, fill)` at the voxels with grade ≠ 0. Bricks and leaves are the same blocks.
template <class Value>
openvdb::FloatGrid::Ptr fog(const BoneView& bone, const Value& value) {
  auto grid = make_float_grid(0.0F);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  bone.voxmap.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick& grades) {
    const FillBricks::Brick* fill = bone.fill.brick(coord);
    auto leaf = std::make_unique<Leaf>(coord_of(GradeBricks::kSide * coord), 0.0F, false);
    for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
      const auto at = static_cast<std::size_t>(offset);
      if (grades[at] == 0) continue;
      leaf->setValueOn(Leaf::coordToOffset(coord_of(BrickLattice::voxel_at(Vec3i::Zero(), offset))),
                       value(grades[at], fill == nullptr ? FillBricks::kWhole : (*fill)[at]));
    }
    put(std::move(leaf), grid->tree());
  });
  return grid;
}

openvdb::FloatGrid::Ptr density_grid(const BoneView& bone) {
  return fog(bone, [](std::uint8_t grade, std::uint16_t) {
    return static_cast<float>(DensityMapping::density_from_grade(grade));
  });
}

openvdb::FloatGrid::Ptr fill_grid(const BoneView& bone) {
  return fog(bone, [](std::uint8_t, std::uint16_t fill) { return static_cast<float>(fill) / FillBricks::kWhole; });
}

openvdb::FloatGrid::Ptr removed_grid(const BoneView& bone, const RemovedFrames& removed) {
  auto grid = make_float_grid(-1.0F);
  auto write = grid->getAccessor();
  for (const auto& [index, frame] : removed) {
    write.setValueOn(coord_of(bone.voxmap.grid.coord(index)), static_cast<float>(frame));
  }
  return grid;
}

openvdb::MetaMap bone_metadata(const BoneView& bone, const Metadata& extra) {
  openvdb::MetaMap out;
  for (const auto& [name, value] : extra) {
    if (!name.empty()) out.insertMeta(name, openvdb::StringMetadata(value));
  }
  const auto set = [&out](const char* name, const openvdb::Metadata& value) {
    out.removeMeta(name);  // it may have another type
    out.insertMeta(name, value);
  };
  const VoxelGrid& grid = bone.voxmap.grid;
  const Vec3& origin = grid.origin_mm;
  set(vdb_keys::kCreator, openvdb::StringMetadata("reamsim " REAMSIM_VERSION));
  set(vdb_keys::kFrame, openvdb::StringMetadata(bone.voxmap.frame));
  set(vdb_keys::kLengthUnit, openvdb::StringMetadata("mm"));
  set(vdb_keys::kDims, openvdb::Vec3IMetadata({grid.dims.x(), grid.dims.y(), grid.dims.z()}));
  set(vdb_keys::kOrigin, openvdb::Vec3DMetadata({origin.x(), origin.y(), origin.z()}));
  set(vdb_keys::kVoxel, openvdb::DoubleMetadata(grid.voxel_mm));
  set(vdb_keys::kAshSlope, openvdb::DoubleMetadata(bone.voxmap.mapping.ash_slope_g_cm3_per_hu));
  set(vdb_keys::kAshOffset, openvdb::DoubleMetadata(bone.voxmap.mapping.ash_offset_g_cm3));
  set(vdb_keys::kAshFraction, openvdb::DoubleMetadata(bone.voxmap.mapping.ash_fraction));
  if (bone.voxmap.layers) set(vdb_keys::kLayers, openvdb::StringMetadata(stored_text(*bone.voxmap.layers)));
  return out;
}

void label(openvdb::FloatGrid& grid, const char* name, const char* unit, const openvdb::MetaMap& metadata,
           const BoneView& bone) {
  for (auto entry = metadata.beginMeta(); entry != metadata.endMeta(); ++entry) {
    if (!grid[entry->first]) grid.insertMeta(entry->first, *entry->second);
  }
  grid.setName(name);
  grid.setCreator("reamsim " REAMSIM_VERSION);
  grid.setTransform(index_transform(bone.voxmap.grid));
  grid.insertMeta(vdb_keys::kUnit, openvdb::StringMetadata(unit));
}

}  // namespace

void write_bone_vdb(const std::string& path, const BoneView& bone, const RemovedFrames& removed,
                    const Metadata& metadata) {
  openvdb::initialize();
  try {
    const openvdb::MetaMap common = bone_metadata(bone, metadata);
    const auto labelled = [&](const openvdb::FloatGrid::Ptr& grid, const char* name, const char* unit) {
      label(*grid, name, unit, common, bone);
      return grid;
    };
    const auto surface = [&] {
      auto grid = labelled(surface_level_set(bone), vdb_keys::kSurface, "mm");
      return_free_memory();
      return grid;
    };
    const std::vector<GridMaker> grids{
        surface,  // first, because it needs the most temporary memory
        [&] { return labelled(density_grid(bone), vdb_keys::kDensity, "g/cm^3"); },
        [&] { return labelled(fill_grid(bone), vdb_keys::kFill, "1"); },
        [&] { return labelled(removed_grid(bone, removed), vdb_keys::kRemovedFrame, "frame index"); }};
    write_vdb_file(path, grids, common);
  } catch (const std::bad_alloc&) {
    throw RunError(path + ": cannot be written (not enough memory for its grids)");
  } catch (const openvdb::Exception&) {
    throw RunError(path + ": cannot be written (OpenVDB refuses its grids or metadata)");
  }
}

}  // namespace reamsim
