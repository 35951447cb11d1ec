#include "render/unreamed_surface.h"

#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/ValueTransformer.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace reamsim {
namespace {

/// The distance grid has about this many cells inside the bone: finer ones cost time and show nothing new, because a
/// distance varies smoothly between them.
constexpr double kInteriorCells = 400'000;

/// A mesh as OpenVDB wants to read it, scaled to `cell`-sized steps.
struct MeshInCells {
  const IsoSurface& surface;
  double scale;

  [[nodiscard]] std::size_t polygonCount() const { return surface.triangles.size(); }
  [[nodiscard]] std::size_t pointCount() const { return surface.points.size(); }
  [[nodiscard]] static std::size_t vertexCount(std::size_t /*polygon*/) { return 3; }
  void getIndexSpacePoint(std::size_t polygon, std::size_t vertex, openvdb::Vec3d& out) const {
    out = openvdb::Vec3d(surface.points[surface.triangles[polygon][static_cast<int>(vertex)]]) * scale;
  }
};

/// Signed distance in mm to a surface whose points times `points_to_cells` are cells of `cell_mm`.
openvdb::FloatGrid::Ptr signed_distance(const IsoSurface& surface, double points_to_cells, double cell_mm,
                                        double outside_cells, float inside_cells) {
  const auto transform = openvdb::math::Transform::createLinearTransform(cell_mm);
  return openvdb::tools::meshToVolume<openvdb::FloatGrid>(MeshInCells{surface, points_to_cells}, *transform,
                                                          static_cast<float>(outside_cells), inside_cells);
}

double cell_size_mm(const Voxmap& voxmap) {
  const auto bone = std::count_if(voxmap.grade.begin(), voxmap.grade.end(), [](std::uint8_t g) { return g != 0; });
  const double bone_mm3 = static_cast<double>(bone) * voxmap.grid.voxel_mm3();
  return std::max(voxmap.grid.voxel_mm, std::cbrt(bone_mm3 / kInteriorCells));
}

/// Depth by closing: the surface is first moved out by kBridge_mm, which shuts narrow holes, and the distance from
/// there is taken less kBridge_mm. Where no hole is near this is the distance from the surface itself.
openvdb::FloatGrid::Ptr depth_grid(const IsoSurface& surface, double voxel_mm, double cell_mm) {
  constexpr double kBridge = UnreamedSurface::kBridge_mm;
  const auto outside = signed_distance(surface, voxel_mm / cell_mm, cell_mm, kBridge / cell_mm + 3, 3.0F);
  const IsoSurface moved = extract_surface(*outside, kBridge);
  auto depth = signed_distance(moved, 1 / cell_mm, cell_mm, 3, std::numeric_limits<float>::max());
  const auto flip = [](const openvdb::FloatGrid::ValueAllIter& value) {
    value.setValue(static_cast<float>(-*value - kBridge));
  };
  openvdb::tools::foreach (depth->beginValueAll(), flip);
  return depth;
}

}  // namespace

UnreamedSurface::UnreamedSurface(const Voxmap& voxmap)
    : occupancy_(voxmap, Occupancy::State::kUnreamed),
      field_(occupancy_),
      surface_(extract_surface(field_.grid(), 0)),
      depth_(depth_grid(surface_, voxmap.grid.voxel_mm, cell_size_mm(voxmap))) {}

}  // namespace reamsim
