// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/figures.h"

#include <filesystem>

#include "render/pictures/run_view.h"
#include "render/surface/reamed_mesh.h"
#include "render/surface/unreamed_surface.h"
#include "sim/mesh/mesh_io.h"

namespace reamsim {
namespace {

double bone_mm3(const Voxmap& voxmap, const FillBricks& fill) {
  std::int64_t sum = 0;  // in 1/65535 of a voxel
  voxmap.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick& grades) {
    const FillBricks::Brick* remaining = fill.brick(coord);
    for (std::size_t i = 0; i < grades.size(); ++i) {
      if (grades[i] != 0) sum += remaining == nullptr ? FillBricks::kWhole : (*remaining)[i];
    }
  });
  return static_cast<double>(sum) / FillBricks::kWhole * voxmap.grid.voxel_mm3();
}

}  // namespace

void write_meshes(const RunData& run, double depth_max_mm, Diagnostics& report) {
  const std::string& dir = run.dir();
  const double remaining_mm3 = bone_mm3(run.voxmap(), run.last_fill());
  const ReamedMesh reamed = make_reamed_mesh(dir + "/reamed.vdb", run.voxmap().grid, remaining_mm3, run.unreamed());
  if (reamed.mesh.triangles.empty()) {
    std::filesystem::remove(dir + "/reamed.glb");
    std::filesystem::remove(dir + "/reamed.stl");
    report.warn("no bone remains: reamed.glb and reamed.stl are not written");
    return;
  }
  write_glb(dir + "/reamed.glb", reamed, depth_scale(run, depth_max_mm).max);
  write_stl(dir + "/reamed.stl", reamed.mesh, "LPS");
}

}  // namespace reamsim
