#pragma once

#include <vector>

#include "kernels/outline.h"
#include "sim/device/opencl.h"
#include "sim/engine/common/nearest_lists.h"
#include "sim/tool/outline.h"

namespace reamsim {

/// The tool's outline as exact erosion reads it (kernels/outline.h).
struct OutlineTable {
  std::vector<OutlinePiece> pieces;
  NearestLists near;
  double bulge_mm = 0;  ///< furthest that the outline lies from the profile's edges

  [[nodiscard]] OutlineView view() const { return {pieces.data(), near.numbers.data(), near.lists.data(), &near.grid}; }
};

/// Every piece in one list: the reference. Corners count as sharp where the lines on both sides are as long as a voxel
/// of `voxel_mm`, because two planes stand for the outline there.
OutlineTable full_outline_table(const Profile& profile, double voxel_mm);

/// Lists for voxels of `voxel_mm`. Gives the same distances and normals as full_outline_table(), bit for bit. Throws
/// InputError beyond 65535 pieces.
OutlineTable make_outline_table(const Profile& profile, double voxel_mm);

/// An outline table on the device.
class DeviceOutline {
 public:
  DeviceOutline() = default;
  DeviceOutline(const cl::Device& device, const OutlineTable& table);
  /// Sets four arguments: pieces, numbers, lists, grid.
  void set(cl::Kernel& kernel, cl_uint first_argument) const;

 private:
  cl::Buffer<OutlinePiece> pieces_;
  cl::Buffer<rs_u16> numbers_;
  cl::Buffer<EdgeList> lists_;
  cl::Buffer<ProfileGrid> grid_;
};

}  // namespace reamsim
