// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/ranges.h>
#include <openvdb/openvdb.h>
#include <algorithm>

#include "sim/base/error.h"
#include "sim/base/parallel.h"
#include "sim/base/process.h"
#include "sim/bone/vdb/bone_vdb.h"
#include "sim/bone/vdb/grids.h"
#include "sim/bone/voxmap/sample_voxels.h"

namespace reamsim {

namespace {

using Leaf = openvdb::FloatTree::LeafNodeType;
static_assert(Leaf::DIM == FillBricks::kSide);

/// The occupancy (0…65535) of a brick and of a layer of one voxel around it.
using Occupancy = PaddedBrick<int>;

/// Weights 1-2-1 along each axis; their sum is 64.
float smoothed(const Occupancy& occupancy, const Vec3i& voxel) {
  constexpr std::size_t kRow = Occupancy::kPaddedSide, kLayer = kRow * kRow;
  const std::size_t first = Occupancy::place(voxel - Vec3i::Ones());
  int sum = 0;
  for (std::size_t dz = 0; dz < 3; ++dz) {
    for (std::size_t dy = 0; dy < 3; ++dy) {
      const int* row = &occupancy.values()[first + kLayer * dz + kRow * dy];
      sum += (dy == 1 ? 2 : 1) * (dz == 1 ? 2 : 1) * (row[0] + 2 * row[1] + row[2]);
    }
  }
  return static_cast<float>(sum) / (64.0F * FillBricks::kWhole);
}

openvdb::Coord leaf_corner(const Vec3i& brick) {
  return vdb_coord(FillBricks::kSide * brick);
}

/// The smoothed occupancy of one brick: a leaf, or a constant 0 or 1. No surface lies between a constant brick and its
/// neighbours: at their common face the smoothed occupancy differs by less than a half from the constant.
struct SmoothedBrick {
  float all = 0;
  std::unique_ptr<Leaf> leaf;
};

SmoothedBrick smoothed_brick(const BoneView& bone, const Vec3i& brick) {
  const auto value = [](const auto& grades, const auto* fill, std::size_t at) -> int {
    return grades[at] == 0 ? 0 : fill == nullptr ? FillBricks::kWhole : (*fill)[at];
  };
  const Occupancy occupancy(bone.voxmap.grade, &bone.fill, brick, value);
  if (occupancy.most() == 0) return {};
  if (occupancy.least() == FillBricks::kWhole) return {1.0F, nullptr};
  auto leaf = std::make_unique<Leaf>(leaf_corner(brick), 0.0F, true);
  for_each_voxel(Vec3i::Constant(FillBricks::kSide), [&](const Vec3i& v) {
    leaf->setValueOnly(Leaf::coordToOffset(vdb_coord(v)), smoothed(occupancy, v));
  });
  return {0, std::move(leaf)};
}

/// Isotropic, in mm, index (0,0,0) at the centre of voxel (0,0,0).
openvdb::math::Transform::Ptr index_transform(const VoxelGrid& grid) {
  auto out = openvdb::math::Transform::createLinearTransform(grid.voxel_mm);
  out->postTranslate(vdb_point(grid.center_mm({0, 0, 0})));
  return out;
}

openvdb::FloatGrid::Ptr smoothed_occupancy(const BoneView& bone) {
  constexpr std::size_t kAtOnce = 1 << 16;
  const std::vector<Vec3i> bricks = bricks_near_bone(bone.voxmap.grade);
  auto grid = make_float_grid(0.0F);
  grid->setTransform(index_transform(bone.voxmap.grid));
  parallel_in_order<SmoothedBrick>(
      bricks.size(), kAtOnce,
      [&](std::size_t i, SmoothedBrick& smoothed) { smoothed = smoothed_brick(bone, bricks[i]); },
      [&](std::size_t i, SmoothedBrick& smoothed) {
        if (smoothed.leaf) {
          grid->tree().addLeaf(smoothed.leaf.release());
        } else if (smoothed.all != 0) {
          // Inactive: only the leaves are searched for the surface.
          grid->tree().addTile(1, leaf_corner(bricks[i]), smoothed.all, false);
        }
      });
  return grid;
}

/// A fog volume of `value(grade, fill)` at the voxels with grade ≠ 0. Bricks and leaves are the same blocks.
template <class Value>
openvdb::FloatGrid::Ptr fog(const BoneView& bone, const Value& value) {
  auto grid = make_float_grid(0.0F);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  bone.voxmap.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick&) {
    auto leaf = std::make_unique<Leaf>(leaf_corner(coord), 0.0F, false);
    for_each_bone_voxel_in(bone, coord, [&](const Vec3i& voxel, std::uint8_t grade, std::uint16_t fill) {
      leaf->setValueOn(Leaf::coordToOffset(vdb_coord(voxel)), value(grade, fill));
    });
    // As a tile if it is constant, as most leaves inside a bone are.
    float all = 0;
    bool active = false;
    if (leaf->isConstant(all, active)) {
      grid->tree().addTile(1, leaf->origin(), all, active);
    } else {
      grid->tree().addLeaf(leaf.release());
    }
  });
  return grid;
}

openvdb::FloatGrid::Ptr removed_grid(const BoneView& bone, const RemovedFrames& removed) {
  auto grid = make_float_grid(-1.0F);
  auto write = grid->getAccessor();
  for (const auto& [index, frame] : removed) {
    write.setValueOn(vdb_coord(bone.voxmap.grid.coord(index)), static_cast<float>(frame));
  }
  return grid;
}

/// Numbers as text that reads back to the same values.
std::string text_of(const std::vector<double>& numbers) {
  return fmt::format("{:.17g}", fmt::join(numbers, " "));
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
  set("creator", openvdb::StringMetadata("reamsim " REAMSIM_VERSION));
  set(vdb_keys::kFrame, openvdb::StringMetadata(bone.voxmap.frame));
  set("length_unit", openvdb::StringMetadata("mm"));
  set(vdb_keys::kDims, openvdb::Vec3IMetadata({grid.dims.x(), grid.dims.y(), grid.dims.z()}));
  set(vdb_keys::kOrigin, openvdb::Vec3DMetadata(vdb_point(grid.origin_mm)));
  set(vdb_keys::kVoxel, openvdb::DoubleMetadata(grid.voxel_mm));
  set(vdb_keys::kAshSlope, openvdb::DoubleMetadata(bone.voxmap.mapping.ash_slope_g_cm3_per_hu));
  set(vdb_keys::kAshOffset, openvdb::DoubleMetadata(bone.voxmap.mapping.ash_offset_g_cm3));
  set(vdb_keys::kAshFraction, openvdb::DoubleMetadata(bone.voxmap.mapping.ash_fraction));
  if (const auto& layers = bone.voxmap.layers) {
    const std::string text = text_of({layers->cortical_mm, layers->cortical_g_cm3, layers->trabecular_g_cm3});
    set(vdb_keys::kLayers, openvdb::StringMetadata(text));
  }
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
  grid.insertMeta("unit", openvdb::StringMetadata(unit));
}

}  // namespace

Metadata metadata_of(const StoredAnatomy& anatomy) {
  Metadata out;
  if (anatomy.side != BodySide::unknown) out.emplace_back(vdb_keys::kSide, name_of(anatomy.side));
  if (anatomy.glenoid) {
    const Mat4 rows = anatomy.glenoid->bone_from_glenoid.matrix().transpose();
    out.emplace_back(vdb_keys::kGlenoid, text_of({rows.data(), rows.data() + rows.size()}));
  }
  if (const auto& marks = anatomy.landmarks) {
    Mat3 points;
    points << marks->glenoid_center_mm, marks->trigonum_spinae_mm, marks->inferior_angle_mm;
    out.emplace_back(vdb_keys::kLandmarks, text_of({points.data(), points.data() + points.size()}));
  }
  return out;
}

void write_bone_vdb(const std::string& path, const BoneView& bone, const RemovedFrames& removed,
                    const Metadata& metadata) {
  openvdb::initialize();
  try {
    const openvdb::MetaMap common = bone_metadata(bone, metadata);
    const auto labelled = [&](const openvdb::FloatGrid::Ptr& grid, const char* name, const char* unit) {
      label(*grid, name, unit, common, bone);
      return grid;
    };
    // The isosurface 0.5 of the occupancy (fill of bone), which is smoothed over 3×3×3 voxels.
    const auto surface = [&] {
      auto grid = labelled(narrow_band(*smoothed_occupancy(bone)), "surface", "mm");
      return_free_memory();
      return grid;
    };
    const auto density_of = [](std::uint8_t grade, std::uint16_t) {
      return static_cast<float>(DensityMapping::density_from_grade(grade));
    };
    const auto fraction_of = [](std::uint8_t, std::uint16_t fill) {
      return static_cast<float>(fill) / FillBricks::kWhole;
    };
    const std::vector<GridMaker> grids{
        surface,  // first, because it needs the most temporary memory
        [&] { return labelled(fog(bone, density_of), vdb_keys::kDensity, "g/cm^3"); },
        [&] { return labelled(fog(bone, fraction_of), vdb_keys::kFill, "1"); },
        [&] { return labelled(removed_grid(bone, removed), "removed_frame", "frame index"); }};
    write_vdb_file(path, grids, common);
  } catch (const std::bad_alloc&) {
    throw RunError(path + ": cannot be written (not enough memory for its grids" + address_space_note("; ") + ")");
  } catch (const openvdb::Exception&) {
    throw RunError(path + ": cannot be written (OpenVDB refuses its grids or metadata)");
  }
}

}  // namespace reamsim
