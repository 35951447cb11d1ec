#pragma once

#include <functional>
#include <vector>

#include "kernels/profile.h"
#include "sim/tool/profile.h"

namespace reamsim {

/// Longest motion within a window of `exact`, that of turning teeth included, voxels: every voxel that a window can
/// meet is looked at in each of its substeps.
inline constexpr double kWindowShiftVoxels = 0.5;

/// For every place near a tool's surface the few parts of its outline in (r, z) that can be nearest there; see
/// ProfileGrid in kernels/profile.h.
struct NearestLists {
  std::vector<rs_u16> numbers;  ///< of parts, list after list; first comes the list of all
  std::vector<EdgeList> lists;
  ProfileGrid grid{};
};

/// Lists for voxels of `voxel_mm`: each holds for all voxels of a brick whose centre lies in its cell. `distance` of a
/// part from a point (r, z), mm; `count` parts.
NearestLists make_nearest_lists(const Profile& profile, std::size_t count,
                                const std::function<double(std::size_t part, const Vec2& rz)>& distance,
                                double voxel_mm);

}  // namespace reamsim
