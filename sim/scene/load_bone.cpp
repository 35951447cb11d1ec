// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scene/load_bone.h"

#include <fmt/core.h>
#include <filesystem>
#include <numbers>
#include <utility>

#include "sim/anatomy/find_glenoid.h"
#include "sim/bone/vdb/bone_vdb.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/scan/ct_import.h"
#include "sim/scenario/parse.h"
#include "sim/scene/bone_store.h"

namespace reamsim {

namespace {

/// Whether a cube around a point contains both bone and air.
bool has_surface_near(const Voxmap& voxmap, const Vec3& point_mm, double within_mm) {
  const VoxelGrid& grid = voxmap.grid;
  // One layer of voxels beyond the lattice represents all air there.
  const Vec3i first = grid.voxel_of(point_mm - Vec3::Constant(within_mm)).cwiseMax(-1);
  const Vec3i last = grid.voxel_of(point_mm + Vec3::Constant(within_mm)).cwiseMin(grid.dims);
  bool bone = false;
  bool air = false;
  for_each_voxel(first, last, [&](const Vec3i& voxel) {
    if (bone && air) return;
    (voxmap.is_bone(voxel) ? bone : air) = true;
  });
  return bone && air;
}

/// Throws InputError if the rim of the scenario does not lie on this bone.
void require_surface_near(const Voxmap& voxmap, const std::vector<Vec3>& rim_mm) {
  constexpr double kWithin_mm = 5;
  for (std::size_t i = 0; i < rim_mm.size(); ++i) {
    const Vec3& p = rim_mm[i];
    if (has_surface_near(voxmap, p, kWithin_mm)) continue;
    const std::string found =
        fmt::format("point {}, ({:.6g}, {:.6g}, {:.6g}), lies more than {:g} mm from the surface of the bone", i + 1,
                    p.x(), p.y(), p.z(), kWithin_mm);
    throw InputError({}, "bone.glenoid.rim_mm", found, "give points on the rim of the face, in the bone frame");
  }
}

void drill(Bone& bone, const PilotHoleSettings& hole, bool partial, Diagnostics& report) {
  FilledVoxmap voxels = bone.copy_voxels();
  const double drilled_mm3 = drill_pilot_hole(voxels, hole, bone.glenoid, partial);
  bone.set_voxels(std::move(voxels));
  if (drilled_mm3 == 0)
    return report.warn("the pilot hole meets no bone: check bone.pilot_hole.entry_mm, axis and depth_mm");
  report.note(fmt::format("pilot hole: diameter {:.4g} mm, {:.1f} mm3 of bone removed", hole.diameter_mm, drilled_mm3));
}

/// Notes where the scenario, which has priority, contradicts the VDB.
void note_contradictions(const BoneSettings& settings, const StoredAnatomy& stored, Diagnostics& report) {
  if (settings.side != BodySide::unknown && stored.side != BodySide::unknown && settings.side != stored.side) {
    report.note("bone.side is " + name_of(settings.side) + ", the VDB says " + name_of(stored.side) +
                "; using that of the scenario");
  }
  const auto given =
      stored.glenoid ? glenoid_frame(settings.glenoid, settings.side == BodySide::unknown ? stored.side : settings.side)
                     : std::nullopt;
  if (!given) return;
  const Rigid apart = stored.glenoid->bone_from_glenoid.inverse() * given->bone_from_glenoid;
  const double angle_deg = Eigen::AngleAxisd(apart.linear()).angle() * 180 / std::numbers::pi;
  const double shift_mm = apart.translation().norm();
  if (shift_mm < 0.01 && angle_deg < 0.01) return;
  report.note(
      fmt::format("bone.glenoid differs from the glenoid frame of the VDB by {:.2f} mm and {:.2f} degrees; using that "
                  "of the scenario",
                  shift_mm, angle_deg));
}

/// Sets the frame and the rim of the face round `near_mm`.
void find_face(Bone& bone, const GlenoidSettings& settings, Diagnostics& report) {
  if (bone.side == BodySide::unknown) {
    throw InputError({}, "bone.side", "missing", "left or right, because bone.glenoid is given");
  }
  const FoundGlenoid found = find_glenoid(bone, settings, bone.side);
  bone.glenoid = found.frame;
  bone.rim_mm = found.rim_mm;
  report.note(found.sentence);
  for (const std::string& doubt : found.doubts) report.warn(doubt);
}

/// The bone of a VDB: of an earlier run or import, or of another program with a FloatGrid `density`. Uses the voxel
/// size and density mapping of the VDB; its glenoid frame, landmarks and side if the scenario has none.
Bone bone_from_vdb(const BoneSettings& settings, Diagnostics& report) {
  constexpr double kRounding = 1e-6;  // of a float
  StoredBone stored = read_stored_bone(settings.vdb.path);
  note_contradictions(settings, stored.anatomy, report);
  Bone bone(std::move(stored.voxmap));
  bone.glenoid = stored.anatomy.glenoid;
  bone.landmarks = stored.anatomy.landmarks;
  bone.side = stored.anatomy.side;
  if (stored.anatomy.glenoid && !settings.glenoid.is_given()) report.note("glenoid frame from the VDB");
  if (stored.densest_g_cm3 > DensityMapping::kMaxDensity_g_cm3 * (1 + kRounding)) {
    report.warn(
        fmt::format("{}: found {:.4g} g/cm3; the most that is represented is {:g} g/cm3, and forces there are "
                    "those of it: is the grid `density` in g/cm3?",
                    settings.vdb.path, stored.densest_g_cm3, DensityMapping::kMaxDensity_g_cm3));
  }
  if (bone.voxmap->grid.voxel_mm != settings.voxel_mm) {
    report.note(fmt::format("voxels of {:.6g} mm from the VDB; bone.voxel_mm is ignored", bone.voxmap->grid.voxel_mm));
  }
  return bone;
}

/// The voxels, without the glenoid frame and the landmarks of the scenario, and without the pilot hole.
Bone bone_from_source(const BoneSettings& settings, Diagnostics& report, const StageSink& stages = {}) {
  if (settings.source == BoneSource::phantom) {
    begin_stage(stages, BoneStage::voxels);
    Bone bone = bone_from_phantom(settings, report);
    bone.set_voxels(fit_to_bone(bone, kMarginVoxels));
    return bone;
  }
  if (settings.source == BoneSource::ct) {
    Bone bone;
    bone.segmentation.emplace();
    bone.set_voxels(fit_to_bone(voxmap_from_ct(settings, report, &*bone.segmentation, stages), kMarginVoxels));
    return bone;
  }
  if (settings.source == BoneSource::mesh)
    return Bone(fit_to_bone(voxmap_from_mesh(settings, report, stages), kMarginVoxels));
  begin_stage(stages, BoneStage::read);
  return bone_from_vdb(settings, report);
}

/// Adds glenoid frame, landmarks and pilot hole. The voxmap is copied only for a pilot hole.
Bone with_anatomy(Bone bone, const BoneSettings& settings, Diagnostics& report) {
  if (settings.side != BodySide::unknown) bone.side = settings.side;
  if (const auto given = glenoid_frame(settings.glenoid, bone.side)) bone.glenoid = given;
  if (settings.glenoid.near_mm) find_face(bone, settings.glenoid, report);
  if (settings.glenoid.landmarks) bone.landmarks = settings.glenoid.landmarks;
  if (!settings.glenoid.rim_mm.empty()) {
    require_surface_near(*bone.voxmap, settings.glenoid.rim_mm);
    bone.rim_mm = settings.glenoid.rim_mm;
  }
  if (bone.landmarks) {  // whose normal is the Friedman axis
    GlenoidSettings marks;
    marks.landmarks = bone.landmarks;
    bone.scapula = axes_of(*glenoid_frame(marks, bone.side), bone.side);
  }
  if (settings.pilot_hole) drill(bone, *settings.pilot_hole, settings.surface_voxels == SurfaceVoxels::partial, report);
  const VoxelGrid& grid = bone.voxmap->grid;
  report.note(fmt::format("bone: {} x {} x {} voxels of {:.4g} mm, {} contain bone, {:.0f} mm3, frame {}",
                          grid.dims.x(), grid.dims.y(), grid.dims.z(), grid.voxel_mm, bone.view().count_bone(),
                          bone.view().bone_mm3(), bone.voxmap->frame));
  return bone;
}

namespace fs = std::filesystem;

/// Length and time of modification of a file, or of each file of a folder.
std::string stamp(const std::string& path) {
  std::error_code error;
  const auto of_file = [&](const fs::path& file) {
    const auto bytes = fs::file_size(file, error);
    return fmt::format("{} {} {}\n", file.string(), bytes, fs::last_write_time(file, error).time_since_epoch().count());
  };
  if (!fs::is_directory(path, error)) return of_file(path);
  std::string out;
  for (fs::recursive_directory_iterator at(path, error), end; !error && at != end; at.increment(error)) {
    if (at->is_regular_file(error)) out += of_file(at->path());
  }
  return out;
}

std::string key_of(const BoneSettings& settings) {
  Scenario scenario;  // whose other sections are the defaults
  scenario.bone = settings;
  std::string key = to_yaml(scenario);
  for (const auto& [role, path] : input_files(scenario)) {
    if (!path.empty()) key += stamp(path);
  }
  return key;
}

}  // namespace

Bone load_bone(const BoneSettings& settings, Diagnostics& report, const StageSink& stages) {
  return BoneStore().find_or_load(settings, report, [&](Diagnostics& said) {
    Bone bone = bone_from_source(settings, said, stages);
    begin_stage(stages, BoneStage::anatomy);
    return with_anatomy(std::move(bone), settings, said);
  });
}

Bone BoneCache::load(const BoneSettings& settings, Diagnostics& report) {
  // Whether the voxels of the bone, and what is said of them, do not depend on its glenoid frame: those of a CT do
  // where the humerus is cut off, or no seed is given.
  const bool shared = settings.source == BoneSource::ct && settings.ct.separate == Separate::none &&
                      settings.ct.seed_mm && !settings.pilot_hole;
  BoneSettings counted = settings;
  if (shared) counted.glenoid = {};
  if (std::string key = key_of(counted); key != key_) {
    key_.clear();
    bone_ = Bone();  // its memory is needed
    report_ = {};
    try {
      bone_ = shared ? bone_from_source(settings, report_) : load_bone(settings, report_);
    } catch (...) {  // also where memory ends: what was said before may be why
      report.append(report_);
      throw;
    }
    key_ = std::move(key);
    ++loaded_;
  }
  report.append(report_);
  return shared ? with_anatomy(bone_, settings, report) : bone_;
}

}  // namespace reamsim
