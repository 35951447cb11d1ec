#pragma once

#include "sim/engine/common/surface_table.h"

namespace reamsim {

/// The tool's profile as the cutting law reads it: edges off the axis (kernels/profile.h).
using ProfileTable = SurfaceTable<ProfileEdge>;
using DeviceProfile = DeviceSurface<ProfileEdge>;

inline ProfileView view_of(const ProfileTable& table) {
  return {table.pieces.data(), table.near.numbers.data(), table.near.lists.data(), &table.near.grid};
}

/// Every edge in one list: the reference.
ProfileTable full_profile_table(const Profile& profile);

/// Lists for voxels of `voxel_mm`: each holds for all voxels of a brick whose centre lies in its cell. Gives
/// the same normals as full_profile_table(), bit for bit. Throws InputError beyond 65535 edges.
ProfileTable make_profile_table(const Profile& profile, double voxel_mm);

}  // namespace reamsim
