// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <openvdb/openvdb.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "sim/isolation/child_result.h"
#include "sim/mesh/triangle_mesh.h"

// Instances that OpenVDB's library has, and whose compilation takes half a minute. It lacks members that are inlined
// everywhere, so an optimising compiler has to inline them here as well (cmake/ReamsimOptions.cmake). Cast grids with
// dynamic_pointer_cast, not gridPtrCast(): a copy of its std::call_once would set the name of a type in the library.
#ifdef REAMSIM_GRIDS_OF_LIBRARY
extern template class openvdb::tree::Tree<openvdb::FloatTree::RootNodeType>;
extern template class openvdb::tree::Tree<openvdb::BoolTree::RootNodeType>;
extern template class openvdb::Grid<openvdb::FloatTree>;
extern template class openvdb::Grid<openvdb::BoolTree>;
#endif

namespace reamsim {

inline openvdb::Coord vdb_coord(const Vec3i& v) {
  return {v.x(), v.y(), v.z()};
}
template <class Point>
openvdb::Vec3d vdb_point(const Point& p) {
  return openvdb::Vec3d(p.x(), p.y(), p.z());
}

// An empty grid with the identity as its transform. Defined in one file, because OpenVDB's create() adds half a minute
// to the compilation of each file that calls it.
openvdb::FloatGrid::Ptr make_float_grid(float background);
openvdb::BoolGrid::Ptr make_bool_grid(bool background);

// Grids as plain arrays, which child processes hand back: values of leaves and tiles, affine transform, metadata.

/// Writes a grid, and empties its leaves on the way.
void put_grid(ResultWriter& out, openvdb::FloatGrid& grid);

/// Throws InputError where the arrays are inconsistent.
openvdb::FloatGrid::Ptr take_grid(ResultReader& in);

/// The lattice and the band of a sampled distance.
struct DistanceSampling {
  Vec3 first_mm = Vec3::Zero();  ///< sample (0,0,0), in the frame of the mesh
  double spacing_mm = 1;
  double outer_spacings = 3;  ///< half-width of the band outside; the distance is constant beyond it
  double inner_spacings = 3;  ///< likewise inside
  bool exact = false;         ///< without OpenVDB's smoothing of overlapping parts, which also moves edges
};

/// Signed distance of a closed mesh in spacings, negative inside. Throws std::bad_alloc or openvdb::Exception.
openvdb::FloatGrid::Ptr mesh_distance(const TriangleMesh& mesh, const DistanceSampling& sampling);

/// Says of a sample whether it lies inside.
using InsideTest = std::function<bool(const Vec3i&)>;
/// The same for a surface that need not be closed: `inside` gives the sign of the samples 0…dims − 1.
openvdb::FloatGrid::Ptr mesh_distance(const TriangleMesh& mesh, const DistanceSampling& sampling, const Vec3i& dims,
                                      const InsideTest& inside);

inline constexpr float kHalfBandVoxels = 3;  ///< half width of the band of a level set, voxels

/// The level set of the surface where an occupancy is one half: signed distance in units of the transform, negative
/// inside, active within kHalfBandVoxels of the surface. `occupancy`: leaves where it is not constant, tiles of 1
/// inside, background 0. A voxel's distance is that of the closest point of the trilinear interpolation: within 0.14
/// voxels on spheres; openvdb::tools::fogToSdf has 0.41, in five to eight times the time.
openvdb::FloatGrid::Ptr narrow_band(const openvdb::FloatGrid& occupancy);

// Files of OpenVDB grids, read by child processes. OpenVDB does not validate what it reads, so a damaged file may crash
// it: files of reamsim end with a checksum after its data, which their metadata announce.

/// Makes a grid that is about to be written.
using GridMaker = std::function<openvdb::GridBase::Ptr()>;

/// Writes the grids and the metadata of the file, which appears when it is complete. Makes a grid while the one before
/// is written. The bytes depend only on the contents. Throws RunError, and what a maker throws.
void write_vdb_file(const std::string& path, const std::vector<GridMaker>& grids, const openvdb::MetaMap& metadata);

/// Whether the beginning of a file is that of write_vdb_file(). Does not check the rest.
bool is_vdb_of_reamsim(const std::string& path);

/// Which programs may have written a file.
enum class VdbOrigin { kAnyProgram, kReamsim };

/// What was read of a VDB file.
struct VdbGrids {
  std::string names;  ///< of all grids, for messages
  std::map<std::string, openvdb::FloatGrid::Ptr> grids;
};

/// Reads those of the `wanted` grids that a file has; none where the first, of which the others are part, is missing.
/// Throws InputError: no such file, a folder, not a VDB, truncated, damaged, a grid that is not a FloatGrid; with
/// VdbOrigin::kReamsim also without checksum.
VdbGrids read_vdb_file(const std::string& path, const std::vector<std::string>& wanted,
                       VdbOrigin origin = VdbOrigin::kAnyProgram);

/// Reads one grid. Throws as read_vdb_file(), and where it is missing.
openvdb::FloatGrid::Ptr read_vdb_grid(const std::string& path, const std::string& name,
                                      VdbOrigin origin = VdbOrigin::kAnyProgram);

}  // namespace reamsim
