#pragma once

#include "sim/bone/bone.h"

namespace reamsim {

/// The parametric glenoid (sim/bone/glenoid_shape.h) with its densities: subchondral plate, cortical wall, trabecular
/// bone that thins out away from the plate, with seeded texture. The glenoid frame stands at the face's centre, +z
/// along its normal; the landmarks are the phantom's own. Says in `report` how the face is turned. Throws InputError:
/// no side, a face radius that the face does not fit on, wear that the face has no room for.
Bone glenoid_phantom(const BoneSettings& settings, Report& report);

/// The same bone over a lattice that the caller chooses; what lies outside it is cut off. Throws as above.
FilledVoxmap sample_glenoid(const BoneSettings& settings, const VoxelGrid& grid);

}  // namespace reamsim
