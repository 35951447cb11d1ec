// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace reamsim {

/// A raster of nx × ny cells, row by row.
struct Raster {
  int nx = 0;
  int ny = 0;

  [[nodiscard]] std::size_t index(int i, int j) const {
    return static_cast<std::size_t>(i) + static_cast<std::size_t>(nx) * static_cast<std::size_t>(j);
  }
  [[nodiscard]] std::size_t count() const { return index(0, ny); }
  [[nodiscard]] bool contains(int i, int j) const { return i >= 0 && j >= 0 && i < nx && j < ny; }
  [[nodiscard]] int column(std::size_t index) const { return static_cast<int>(index) % nx; }
  [[nodiscard]] int row(std::size_t index) const { return static_cast<int>(index) / nx; }
  /// Calls visit(index) for each cell at most `reach` cells from `center` along either axis.
  template <typename Visit>
  void for_each_near(std::size_t center, int reach, const Visit& visit) const {
    const int last_i = std::min(column(center) + reach, nx - 1), last_j = std::min(row(center) + reach, ny - 1);
    for (int j = std::max(row(center) - reach, 0); j <= last_j; ++j) {
      for (int i = std::max(column(center) - reach, 0); i <= last_i; ++i) visit(index(i, j));
    }
  }
};

/// The mask (1 or 0 per cell), smoothed so that its contour at half of `limit` does not follow the cells' edges.
/// `limit`: the most that a cell can hold, 1 or the smoothed mask that this one is a part of. Isolated patches of a few
/// cells, inside or outside, are kept and become round; spurs one cell wide may vanish.
std::vector<double> smoothed_mask(const Raster& raster, const std::vector<std::uint8_t>& mask,
                                  const std::vector<double>& limit);

}  // namespace reamsim
