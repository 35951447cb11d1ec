#pragma once

#include <cstdint>
#include <vector>

namespace reamsim {

/// A raster of cells that are in something or not, row by row.
struct CellMask {
  int nx = 0;
  int ny = 0;
  std::vector<std::uint8_t> in;  ///< 1 or 0

  [[nodiscard]] std::size_t index(int i, int j) const {
    return static_cast<std::size_t>(i) + static_cast<std::size_t>(nx) * static_cast<std::size_t>(j);
  }
  [[nodiscard]] bool holds(int i, int j) const { return i >= 0 && j >= 0 && i < nx && j < ny; }
};

/// How much of what lies round each cell is in: half of `of` is then an outline that does not go along the cells'
/// edges. `of`, from 0 to 1, is what a cell can hold at most: 1, or the share of what the mask is a part of. A patch of
/// a few cells, in or out, that stands alone stays, and is round; a spur or a sliver of one cell's width may go.
std::vector<double> smoothed_mask(const CellMask& mask, const std::vector<double>& of);

}  // namespace reamsim
