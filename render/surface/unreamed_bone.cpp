#include "render/surface/unreamed_bone.h"

#include <openvdb/tools/MeshToVolume.h>

#include <cmath>
#include <utility>

#include "render/surface/occupancy.h"
#include "sim/bone/vdb/vdb_grid.h"

namespace reamsim {
namespace {

/// A bone has about this many depth cells inside: finer ones cost time and show nothing new, because a distance varies
/// smoothly between them.
constexpr double kInteriorCells = 400'000;

double cell_size_mm(const Voxmap& voxmap) {
  const double bone_mm3 = static_cast<double>(voxmap.grade.count()) * voxmap.grid.voxel_mm3();
  return std::max(voxmap.grid.voxel_mm, std::cbrt(bone_mm3 / kInteriorCells));
}

MovedSurface move_out(const IsoSurface& surface, double voxel_mm, double cell_mm) {
  const auto transform = openvdb::math::Transform::createLinearTransform(cell_mm);
  const auto outside_cells = static_cast<float>(UnreamedBone::kBridge_mm / cell_mm + 3);
  MovedSurface out;
  out.cell_mm = cell_mm;
  if (surface.triangles.empty()) {  // no bone, or less than a voxel of it
    out.distance_mm = make_float_grid(outside_cells * static_cast<float>(cell_mm));
    out.distance_mm->setTransform(transform);
    return out;
  }
  std::vector<openvdb::Vec3s> in_cells = surface.points;
  for (openvdb::Vec3s& p : in_cells) p *= static_cast<float>(voxel_mm / cell_mm);
  // This adapter and interrupter are the ones that OpenVDB's library holds compiled; others take minutes to compile.
  const openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3s, openvdb::Vec3I> mesh(in_cells, surface.triangles);
  openvdb::util::NullInterrupter never;
  out.distance_mm = openvdb::tools::meshToVolume<openvdb::FloatGrid>(never, mesh, *transform, outside_cells, 3.0F);
  out.surface = extract_surface(*out.distance_mm, UnreamedBone::kBridge_mm);
  return out;
}

}  // namespace

UnreamedBone::UnreamedBone(const Voxmap& voxmap, FillBricks before)
    : before_(std::move(before)),
      field_(Occupancy(voxmap, before_)),
      surface_(extract_surface(field_.grid(), 0)),
      moved_(move_out(surface_, voxmap.grid.voxel_mm, cell_size_mm(voxmap))) {}

}  // namespace reamsim
