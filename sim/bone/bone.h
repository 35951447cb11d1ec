#pragma once

#include <optional>

#include "sim/base/report.h"
#include "sim/bone/voxmap.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// A bone ready to be reamed.
struct Bone {
  Voxmap voxmap;
  std::optional<GlenoidFrame> glenoid;  ///< from the scenario, or the phantom's own
};

/// Builds the bone that the scenario asks for (CT, mesh, VDB or phantom) and drills the pilot hole.
/// Throws InputError for whatever is wrong with the data; says in `report` what was done (voxels, volumes, pieces).
Bone load_bone(const BoneSettings& settings, Report& report);

/// The sources behind load_bone(), with voxmap_from_ct() (sim/bone/ct/ct_import.h). Each gives an isotropic voxmap of
/// `settings.voxel_mm` in the frame B.
Voxmap voxmap_from_mesh(const BoneSettings& settings, Report& report);
Voxmap voxmap_from_vdb(const BoneSettings& settings, Report& report);
Bone bone_from_phantom(const BoneSettings& settings, Report& report);

/// The glenoid frame of the scenario, from centre/normal/superior or from landmarks; nullopt where neither is given.
std::optional<GlenoidFrame> glenoid_frame(const GlenoidSettings& settings, const std::string& side);

/// Sets every voxel whose centre lies in the hole to air; returns the drilled volume in mm³.
double drill_pilot_hole(Voxmap& voxmap, const PilotHoleSettings& hole);

/// Shrinks or grows the lattice so that `margin_voxels` of air surround the bone on every side, and the dimensions are
/// multiples of 8 (whole bricks). Throws InputError when there is no bone.
Voxmap fit_to_bone(const Voxmap& voxmap, int margin_voxels);

}  // namespace reamsim
