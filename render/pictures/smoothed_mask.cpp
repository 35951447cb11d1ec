// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/smoothed_mask.h"

#include <cstddef>

#include "sim/base/statistics.h"

namespace reamsim {
namespace {

constexpr int kBlurReach = 5;
constexpr double kBlurSigma = 1.6;       // cells
constexpr std::size_t kLargePatch = 40;  // cells; larger patches survive the blur
constexpr int kPatchHalo = 2;            // cells around a patch that are raised with it
constexpr double kKeptFraction = 0.52;   // least fraction of the limit in a cell of a patch

/// Convolution along one axis; cells beyond the raster are 0.
std::vector<double> blurred(const Raster& raster, const std::vector<double>& values, int step_i, int step_j) {
  const std::vector<double> weights = gaussian_weights(kBlurSigma, kBlurReach);
  std::vector<double> out(values.size(), 0.0);
  for (int j = 0; j < raster.ny; ++j) {
    for (int i = 0; i < raster.nx; ++i) {
      for (int n = -kBlurReach; n <= kBlurReach; ++n) {
        const int a = i + n * step_i, b = j + n * step_j;
        if (!raster.contains(a, b)) continue;
        out[raster.index(i, j)] += weights[static_cast<std::size_t>(n + kBlurReach)] * values[raster.index(a, b)];
      }
    }
  }
  return out;
}

/// The connected cells of equal value around a cell.
std::vector<std::size_t> patch_of(const Raster& raster, const std::vector<std::uint8_t>& mask, std::size_t first,
                                  std::vector<std::uint8_t>& seen) {
  std::vector<std::size_t> patch{first};
  seen[first] = 1;
  for (std::size_t k = 0; k < patch.size(); ++k) {
    raster.for_each_near(patch[k], 1, [&](std::size_t cell) {
      if (seen[cell] != 0 || mask[cell] != mask[first]) return;
      seen[cell] = 1;
      patch.push_back(cell);
    });
  }
  return patch;
}

bool at_border(const Raster& raster, std::size_t cell) {
  const int i = raster.column(cell), j = raster.row(cell);
  return i == 0 || j == 0 || i == raster.nx - 1 || j == raster.ny - 1;
}

/// Raises the values in and around a patch until its cells are on their own side of the contour.
void raise_patch(const Raster& raster, bool inside, const std::vector<std::size_t>& patch,
                 const std::vector<double>& limit, std::vector<double>& values) {
  const auto own = [&](std::size_t cell) { return inside ? values[cell] : limit[cell] - values[cell]; };
  double least = kKeptFraction;
  for (const std::size_t cell : patch) {
    if (limit[cell] > 0.5) least = std::min(least, own(cell) / limit[cell]);
  }
  if (least >= kKeptFraction || least <= 0) return;
  std::vector<std::size_t> halo;
  for (const std::size_t cell : patch) {
    raster.for_each_near(cell, kPatchHalo, [&](std::size_t near) { halo.push_back(near); });
  }
  std::sort(halo.begin(), halo.end());
  halo.erase(std::unique(halo.begin(), halo.end()), halo.end());
  for (const std::size_t cell : halo) {
    const double raised = std::min(limit[cell], own(cell) * kKeptFraction / least);
    values[cell] = inside ? raised : limit[cell] - raised;
  }
}

}  // namespace

std::vector<double> smoothed_mask(const Raster& raster, const std::vector<std::uint8_t>& mask,
                                  const std::vector<double>& limit) {
  std::vector<double> values = blurred(raster, blurred(raster, {mask.begin(), mask.end()}, 1, 0), 0, 1);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::min(values[i], limit[i]);
  std::vector<std::uint8_t> seen(mask.size(), 0);
  for (std::size_t first = 0; first < mask.size(); ++first) {
    if (seen[first] != 0) continue;
    const std::vector<std::size_t> patch = patch_of(raster, mask, first, seen);
    const bool inside = mask[first] != 0;
    // A patch of zeros at the border continues beyond it, where all is 0.
    const bool open = !inside && std::ranges::any_of(patch, [&](std::size_t cell) { return at_border(raster, cell); });
    if (patch.size() < kLargePatch && !open) raise_patch(raster, inside, patch, limit, values);
  }
  return values;
}

}  // namespace reamsim
