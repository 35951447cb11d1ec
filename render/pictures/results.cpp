#include "render/pictures/results.h"

#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <filesystem>

#include "sim/base/error.h"
#include "sim/bone/vdb/bone_vdb.h"
#include "sim/bone/vdb/stored_anatomy.h"
#include "sim/mesh/mesh_io.h"
#include "sim/record/snapshot.h"

namespace reamsim {
namespace {

/// The metadata of the grid `density`; empty when there is none.
openvdb::MetaMap density_metadata(const std::string& path) {
  openvdb::initialize();
  try {
    openvdb::io::File file(path);
    file.open(false);
    const auto grid = file.readGridMetadata("density");
    return grid ? openvdb::MetaMap(*grid) : openvdb::MetaMap();
  } catch (const std::exception&) {
    throw InputError({path, 0, 0}, "density", "its metadata cannot be read", "the reamed.vdb of a run");
  }
}

std::string text_of(const openvdb::MetaMap& metadata, const char* name) {
  const auto found = metadata.getMetadata<openvdb::StringMetadata>(name);
  return found ? found->value() : std::string();
}

Anatomy anatomy_of(const std::string& path, const openvdb::MetaMap& metadata) {
  return {.glenoid = parse_stored_glenoid(path, text_of(metadata, "bone_from_glenoid")),
          .side = checked_stored_side(path, text_of(metadata, "bone_side"))};
}

/// The fill that the run began with.
FillBricks fill_before(const std::string& dir, std::int64_t first_frame, const Vec3i& dims) {
  FillBricks out(dims);
  if (first_frame == 0) apply_snapshot(dir, first_frame, out);
  return out;
}

}  // namespace

Anatomy read_anatomy(const std::string& dir) {
  const std::string path = dir + "/reamed.vdb";
  return anatomy_of(path, density_metadata(path));
}

RunResults read_results(const std::string& dir, std::shared_ptr<const Voxmap> bone, FillBricks fill) {
  RunResults out;
  out.bone_mm3 = BoneView(*bone, fill).bone_mm3();
  out.bone = std::move(bone);
  out.fill = std::move(fill);
  out.log_path = dir + "/forces.csv";
  out.log = read_force_log(out.log_path);
  return out;
}

RunResults read_results(const std::string& dir) {
  if (!std::filesystem::is_directory(dir)) {
    throw InputError({dir, 0, 0}, "", "no such folder", "the output folder of a run");
  }
  FilledVoxmap bone = read_bone_vdb(dir + "/reamed.vdb");
  FillBricks fill = std::move(bone.fill);
  return read_results(dir, std::make_shared<const Voxmap>(std::move(bone)), std::move(fill));
}

RunPlan read_plan(const std::string& dir, const RunResults& results) {
  RunPlan out;
  out.dir = dir;
  out.bone = results.bone;
  const std::string path = dir + "/reamed.vdb";
  const openvdb::MetaMap metadata = density_metadata(path);
  const Anatomy anatomy = anatomy_of(path, metadata);
  out.glenoid = anatomy.glenoid;
  out.side = anatomy.side;
  const auto erosion = from_name<ErosionMode>(text_of(metadata, "erosion"));
  out.whole_voxels = erosion == ErosionMode::remove || erosion == ErosionMode::wear;
  out.frames = snapshot_frames(dir);
  if (out.frames.empty()) {
    throw InputError({dir + "/snapshots", 0, 0}, "", "no snapshot there", "the output folder of a run");
  }
  for (const std::int64_t frame : out.frames) static_cast<void>(results.row_of(frame));
  for (const ForceRow& row : results.log.rows) {
    out.pose_frames.push_back(row.frame);
    out.poses.push_back(row.pose);
  }
  out.fill_before = fill_before(dir, out.frames.front(), out.bone->grid.dims);
  out.tool = read_tool(dir);
  return out;
}

std::string tool_path(const std::string& dir) {
  return dir + "/snapshots/tool.stl";
}

TriangleMesh read_tool(const std::string& dir) {
  return read_mesh(tool_path(dir), 1.0);
}

}  // namespace reamsim
