#pragma once

#include <vector>

#include "sim/device/opencl.h"
#include "sim/engine/common/nearest_lists.h"

namespace reamsim {

/// The tool's generatrix in (r, z) as kernels read it: pieces, and for every place near the surface the few that can be
/// nearest there, so that a voxel's distance takes constant time whatever the profile's length.
template <class Piece>
struct SurfaceTable {
  std::vector<Piece> pieces;
  NearestLists near;
  double bulge_mm = 0;  ///< furthest that a piece lies from the profile's edges
};

/// A table on the device.
template <class Piece>
class DeviceSurface {
 public:
  DeviceSurface() = default;
  DeviceSurface(const cl::Device& device, const SurfaceTable<Piece>& table)
      : pieces_(uploaded(device, table.pieces)),
        numbers_(uploaded(device, table.near.numbers)),
        lists_(uploaded(device, table.near.lists)),
        grid_(uploaded(device, std::vector{table.near.grid})) {}

  /// Sets four arguments from `first` on: pieces, numbers, lists, grid.
  template <class Argument>
  void set(cl::Kernel& kernel, Argument first) const {
    kernel.set_from(first, pieces_, numbers_, lists_, grid_);
  }

 private:
  template <class T>
  static cl::Buffer<T> uploaded(const cl::Device& device, const std::vector<T>& data) {
    return cl::upload(device, data, "the tool's surface");
  }

  cl::Buffer<Piece> pieces_;
  cl::Buffer<rs_u16> numbers_;
  cl::Buffer<EdgeList> lists_;
  cl::Buffer<ProfileGrid> grid_;
};

}  // namespace reamsim
