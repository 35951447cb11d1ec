#pragma once

#include <openvdb/openvdb.h>

#include <cstdint>
#include <vector>

#include "render/surface/occupancy.h"

namespace reamsim {

/// The solid as a smooth field that is negative inside and zero on the surface: ½ − (share of bone), the share smoothed
/// by a Gaussian of kSmoothing_voxels, which takes the voxels' steps away and moves a flat face by nothing.
/// In voxel index space: voxel (i,j,k) has its centre at (i,j,k).
class SolidField {
 public:
  static constexpr double kSmoothing_voxels = 1.0;

  explicit SolidField(const Occupancy& occupancy);

  /// Follows `occupancy`, which has been updated with the same bricks.
  void update(const Occupancy& occupancy, const std::vector<Vec3i>& bricks);

  [[nodiscard]] const openvdb::FloatGrid& grid() const { return *grid_; }

 private:
  void compute(const Occupancy& occupancy, const std::vector<Vec3i>& bricks);

  openvdb::FloatGrid::Ptr grid_;
};

/// A surface as OpenVDB's mesher makes it: corners in voxel index space, triangles counter-clockwise seen from outside.
struct IsoSurface {
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
};

/// The surface where `field` has the value `level`, in the grid's world space; with `where`, only that of its active
/// voxels.
IsoSurface extract_surface(const openvdb::FloatGrid& field, double level, openvdb::BoolGrid::ConstPtr where = nullptr);

/// Three indices per triangle, one after the other.
std::vector<std::uint32_t> flat_indices(const IsoSurface& surface);

}  // namespace reamsim
