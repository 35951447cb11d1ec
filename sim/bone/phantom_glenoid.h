#pragma once

#include "sim/bone/bone.h"

namespace reamsim {

/// The parametric glenoid (sim/bone/glenoid_shape.h) with its densities: subchondral plate, cortical wall, trabecular
/// bone that thins out away from the plate, with seeded texture. The glenoid frame stands at the face centre, +z along
/// the face normal. Throws InputError: no side, a face radius that the face does not fit on.
Bone glenoid_phantom(const BoneSettings& settings);

/// The same bone over a lattice that the caller chooses; what lies outside it is cut off. Throws as above.
Voxmap sample_glenoid(const BoneSettings& settings, const VoxelGrid& grid);

}  // namespace reamsim
