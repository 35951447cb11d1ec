#include "render/pictures/soft_outline.h"

#include <algorithm>
#include <cstddef>

#include "sim/base/gaussian.h"

namespace reamsim {
namespace {

constexpr int kBlurReach = 5;
constexpr double kBlurSigma = 1.6;       // cells
constexpr std::size_t kLargePatch = 40;  // cells; such a patch stays without help
constexpr int kPatchHalo = 2;            // cells round a patch that are raised with it
constexpr double kKept = 0.52;           // of what a cell of a patch can hold, at least

/// The sum along one axis; what is beyond the raster is out.
std::vector<double> blurred(const CellMask& raster, const std::vector<double>& values, int step_i, int step_j) {
  const std::vector<double> weights = gaussian_weights(kBlurSigma, kBlurReach);
  std::vector<double> out(values.size(), 0.0);
  for (int j = 0; j < raster.ny; ++j) {
    for (int i = 0; i < raster.nx; ++i) {
      for (int n = -kBlurReach; n <= kBlurReach; ++n) {
        const int a = i + n * step_i, b = j + n * step_j;
        if (!raster.holds(a, b)) continue;
        out[raster.index(i, j)] += weights[static_cast<std::size_t>(n + kBlurReach)] * values[raster.index(a, b)];
      }
    }
  }
  return out;
}

struct MaskCell {
  int i;
  int j;
};

/// Calls visit(place) for the cells no farther than `reach` from one, along either axis, that lie in the raster.
template <typename Visit>
void cells_round(const CellMask& raster, const MaskCell& at, int reach, const Visit& visit) {
  for (int j = at.j - reach; j <= at.j + reach; ++j) {
    for (int i = at.i - reach; i <= at.i + reach; ++i) {
      if (raster.holds(i, j)) visit(MaskCell{i, j});
    }
  }
}

/// The cells that hang together with one and are as it is.
std::vector<MaskCell> patch_of(const CellMask& mask, const MaskCell& first, std::vector<std::uint8_t>& seen) {
  std::vector<MaskCell> patch{first};
  seen[mask.index(first.i, first.j)] = 1;
  for (std::size_t k = 0; k < patch.size(); ++k) {
    const MaskCell at = patch[k];
    cells_round(mask, at, 1, [&](const MaskCell& beside) {
      const std::size_t index = mask.index(beside.i, beside.j);
      if (seen[index] != 0 || mask.in[index] != mask.in[mask.index(at.i, at.j)]) return;
      seen[index] = 1;
      patch.push_back(beside);
    });
  }
  return patch;
}

/// Does the patch go on beyond the raster, where all is out?
bool goes_on(const CellMask& mask, const std::vector<MaskCell>& patch) {
  if (mask.in[mask.index(patch.front().i, patch.front().j)] != 0) return false;
  return std::any_of(patch.begin(), patch.end(), [&](const MaskCell& at) {
    return at.i == 0 || at.j == 0 || at.i == mask.nx - 1 || at.j == mask.ny - 1;
  });
}

/// Raises what a patch has of each cell in and round it, until its own cells stay on its side.
void raise_patch(const CellMask& mask, const std::vector<MaskCell>& patch, const std::vector<double>& of,
                 std::vector<double>& shares) {
  const bool in = mask.in[mask.index(patch.front().i, patch.front().j)] != 0;
  const auto own = [&](std::size_t index) { return in ? shares[index] : of[index] - shares[index]; };
  double least = kKept;
  for (const MaskCell& at : patch) {
    const std::size_t index = mask.index(at.i, at.j);
    if (of[index] > 0.5) least = std::min(least, own(index) / of[index]);
  }
  if (least >= kKept || least <= 0) return;
  std::vector<std::size_t> halo;
  for (const MaskCell& at : patch) {
    cells_round(mask, at, kPatchHalo, [&](const MaskCell& beside) { halo.push_back(mask.index(beside.i, beside.j)); });
  }
  std::sort(halo.begin(), halo.end());
  halo.erase(std::unique(halo.begin(), halo.end()), halo.end());
  for (const std::size_t index : halo) {
    const double raised = std::min(of[index], own(index) * kKept / least);
    shares[index] = in ? raised : of[index] - raised;
  }
}

}  // namespace

std::vector<double> smoothed_mask(const CellMask& mask, const std::vector<double>& of) {
  const std::vector<double> hard(mask.in.begin(), mask.in.end());
  std::vector<double> shares = blurred(mask, blurred(mask, hard, 1, 0), 0, 1);
  for (std::size_t i = 0; i < shares.size(); ++i) shares[i] = std::min(shares[i], of[i]);
  std::vector<std::uint8_t> seen(mask.in.size(), 0);
  for (int j = 0; j < mask.ny; ++j) {
    for (int i = 0; i < mask.nx; ++i) {
      if (seen[mask.index(i, j)] != 0) continue;
      const std::vector<MaskCell> patch = patch_of(mask, {i, j}, seen);
      if (patch.size() < kLargePatch && !goes_on(mask, patch)) raise_patch(mask, patch, of, shares);
    }
  }
  return shares;
}

}  // namespace reamsim
