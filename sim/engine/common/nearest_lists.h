// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <vector>

#include "kernels/outline.h"
#include "sim/tool/profile.h"

namespace reamsim {

/// Largest motion within a window of `exact`, rotation of resolved cutting edges included, voxels: every candidate
/// voxel of a window is tested in each of its substeps.
inline constexpr double kWindowShiftVoxels = 0.5;

/// Lists of the parts of a tool's outline in (r, z) that can be nearest, by cell; see OutlineGrid in kernels/outline.h.
struct NearestLists {
  std::vector<rs_u16> numbers;  ///< of parts, list after list, beginning with the list of all
  std::vector<PieceList> lists;
  OutlineGrid grid{};
};

/// Lists for voxels of `voxel_mm`: each is valid for all voxels of a brick whose centre lies in its cell. `distance` of
/// a part from a point (r, z), mm; `count` parts.
NearestLists make_nearest_lists(const Profile& profile, std::size_t count,
                                const std::function<double(std::size_t part, const Vec2& rz)>& distance,
                                double voxel_mm);

}  // namespace reamsim
