#pragma once

#include "sim/engine/common/surface_table.h"

namespace reamsim {

/// The tool's profile for the force law: edges off the axis (kernels/profile.h).
using ProfileTable = SurfaceTable<ProfileEdge>;
using DeviceProfile = DeviceSurface<ProfileEdge>;

inline ProfileView view_of(const ProfileTable& table) {
  return {table.pieces.data(), table.near.numbers.data(), table.near.lists.data(), &table.near.grid};
}

/// All edges in one list: the reference.
ProfileTable full_profile_table(const Profile& profile);

/// With lists for voxels of `voxel_mm`. Normals are bitwise those of full_profile_table(). Throws InputError beyond
/// 65535 edges.
ProfileTable make_profile_table(const Profile& profile, double voxel_mm);

}  // namespace reamsim
