#pragma once

#include <vector>

#include "kernels/profile.h"
#include "sim/device/opencl.h"
#include "sim/tool/profile.h"

namespace reamsim {

/// The tool's profile as the cutting law reads it: edges off the axis, and for every place near the surface the few
/// that can be nearest there, so that a voxel's normal takes constant time whatever the profile's length.
struct ProfileTable {
  std::vector<ProfileEdge> edges;
  std::vector<rs_u16> numbers;
  std::vector<EdgeList> lists;
  ProfileGrid grid{};

  [[nodiscard]] ProfileView view() const { return {edges.data(), numbers.data(), lists.data(), &grid}; }
};

/// Every edge in one list: the reference.
ProfileTable full_profile_table(const Profile& profile);

/// Lists for voxels of `voxel_mm`: each holds for all voxels of a brick whose centre lies in its cell. Gives
/// the same normals as full_profile_table(), bit for bit. Throws InputError beyond 65535 edges.
ProfileTable make_profile_table(const Profile& profile, double voxel_mm);

/// A profile table on the device.
class DeviceProfile {
 public:
  DeviceProfile() = default;
  DeviceProfile(const cl::Device& device, const ProfileTable& table);
  /// Sets four arguments: edges, numbers, lists, grid.
  void set(cl::Kernel& kernel, cl_uint first_argument) const;

 private:
  cl::Buffer<ProfileEdge> edges_;
  cl::Buffer<rs_u16> numbers_;
  cl::Buffer<EdgeList> lists_;
  cl::Buffer<ProfileGrid> grid_;
};

}  // namespace reamsim
