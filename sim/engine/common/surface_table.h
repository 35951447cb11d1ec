#pragma once

#include <array>
#include <tuple>
#include <vector>

#include "sim/device/opencl.h"
#include "sim/engine/common/nearest_lists.h"

namespace reamsim {

/// The tool's generatrix in (r, z) as kernels read it: pieces, and for each cell near the surface the list of pieces
/// that can be nearest there. The distance of a voxel then takes constant time, whatever the length of the profile.
template <class Piece>
struct SurfaceTable {
  std::vector<Piece> pieces;
  NearestLists near;
  double bulge_mm = 0;  ///< largest distance of a piece from the profile's edges
};

/// A table on the device.
template <class Piece>
class DeviceSurface {
 public:
  DeviceSurface() = default;
  DeviceSurface(const cl::Device& device, const SurfaceTable<Piece>& table)
      : pieces_(cl::upload(device, table.pieces, kWhat)),
        numbers_(cl::upload(device, table.near.numbers, kWhat)),
        lists_(cl::upload(device, table.near.lists, kWhat)),
        grid_(cl::upload(device, std::array{table.near.grid}, kWhat)) {}

  /// Four arguments of a kernel: pieces, numbers, lists, grid.
  [[nodiscard]] auto arguments() const { return std::tie(pieces_, numbers_, lists_, grid_); }

 private:
  static constexpr const char* kWhat = "the tool's surface";

  cl::Buffer<Piece> pieces_;
  cl::Buffer<rs_u16> numbers_;
  cl::Buffer<EdgeList> lists_;
  cl::Buffer<ProfileGrid> grid_;
};

}  // namespace reamsim
