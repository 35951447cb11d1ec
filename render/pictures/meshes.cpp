#include "render/pictures/meshes.h"

#include <openvdb/io/File.h>

#include <filesystem>

#include "render/pictures/results.h"
#include "render/pictures/run_view.h"
#include "render/surface/glb.h"
#include "render/surface/reamed_mesh.h"
#include "render/surface/unreamed_surface.h"
#include "sim/base/error.h"
#include "sim/mesh/mesh_io.h"

namespace reamsim {
namespace {

openvdb::FloatGrid::Ptr read_surface(const std::string& path) {
  try {
    openvdb::io::File file(path);
    file.open(false);
    auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("surface"));
    if (grid) return grid;
  } catch (const openvdb::Exception&) {
  }
  throw InputError({path, 0, 0}, "surface", "no such grid, or damaged", "the reamed.vdb of a run");
}

}  // namespace

void write_meshes(const FinishedRun& run, double depth_max_mm, Report& report) {
  const std::string& dir = run.dir();
  const RunResults& results = run.results();
  const ReamedMesh reamed = make_reamed_mesh(*read_surface(dir + "/reamed.vdb"), results.bone->grid, results.bone_mm3,
                                             run.planned().unreamed());
  if (reamed.mesh.triangles.empty()) {
    std::filesystem::remove(dir + "/reamed.glb");
    std::filesystem::remove(dir + "/reamed.stl");
    report.warn("no bone is left to mesh: no reamed.glb and no reamed.stl");
    return;
  }
  write_glb(dir + "/reamed.glb", reamed, depth_scale(run.planned(), depth_max_mm).max);
  write_stl(dir + "/reamed.stl", reamed.mesh);
}

}  // namespace reamsim
