// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/contour_lines.h"

#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "sim/base/csv.h"
#include "sim/base/statistics.h"

namespace reamsim {
namespace {

constexpr std::array<std::string_view, 5> kColumnNames{"x_mm", "y_mm", "before_z_mm", "after_z_mm", "depth_mm"};
/// Limit of a valid raster, against damaged files.
constexpr double kMaxCells = 1e8;

/// The least difference between distinct values.
double least_step(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double step = values[i] - values[i - 1];
    if (step > 1e-9) least = std::min(least, step);
  }
  return least;
}

constexpr int kBlurReach = 5;            // cells
constexpr double kBlurSigma = 1.6;       // cells
constexpr std::size_t kLargePatch = 40;  // cells; larger patches survive the blur
constexpr int kPatchHalo = 2;            // cells around a patch that are raised with it
constexpr double kKeptFraction = 0.52;   // least fraction of the limit in a cell of a patch

/// Convolution along one axis; cells beyond the raster are 0.
std::vector<double> blurred(const Raster& raster, const std::vector<double>& values, int step_i, int step_j) {
  const std::vector<double> weights = gaussian_weights(kBlurSigma, kBlurReach);
  std::vector<double> out(values.size(), 0.0);
  for (std::size_t cell = 0; cell < values.size(); ++cell) {
    for (int n = -kBlurReach; n <= kBlurReach; ++n) {
      const int i = raster.column(cell) + n * step_i, j = raster.row(cell) + n * step_j;
      if (!raster.contains(i, j)) continue;
      out[cell] += weights[static_cast<std::size_t>(n + kBlurReach)] * values[raster.index(i, j)];
    }
  }
  return out;
}

/// Extends a patch by all connected cells for which take(cell): it belongs to the patch and was not taken before.
template <class Take>
void flood(const Raster& raster, std::vector<std::size_t>& patch, const Take& take) {
  for (std::size_t k = 0; k < patch.size(); ++k) {
    raster.for_each_near(patch[k], 1, [&](std::size_t cell) {
      if (take(cell)) patch.push_back(cell);
    });
  }
}

/// Whether a cell is less than `reach` cells from the border of the raster.
bool near_border(const Raster& raster, std::size_t cell, int reach) {
  const int i = raster.column(cell), j = raster.row(cell);
  return !raster.contains(i - reach, j - reach) || !raster.contains(i + reach, j + reach);
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
  std::set<std::size_t> halo;
  for (const std::size_t cell : patch) {
    raster.for_each_near(cell, kPatchHalo, [&](std::size_t near) { halo.insert(near); });
  }
  for (const std::size_t cell : halo) {
    const double raised = std::min(limit[cell], own(cell) * kKeptFraction / least);
    values[cell] = inside ? raised : limit[cell] - raised;
  }
}

/// The mask (1 or 0), smoothed so that its contour at half of `limit` (1, or the smoothed mask that it is a part of)
/// does not follow the cells' edges. Isolated patches of few cells become round; spurs one cell wide may vanish.
std::vector<double> smoothed_mask(const Raster& raster, const std::vector<std::uint8_t>& mask,
                                  const std::vector<double>& limit) {
  std::vector<double> values = blurred(raster, blurred(raster, {mask.begin(), mask.end()}, 1, 0), 0, 1);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::min(values[i], limit[i]);
  std::vector<std::uint8_t> seen(mask.size(), 0);
  for (std::size_t first = 0; first < mask.size(); ++first) {
    if (std::exchange(seen[first], 1) != 0) continue;
    std::vector<std::size_t> patch{first};
    flood(raster, patch,
          [&](std::size_t cell) { return mask[cell] == mask[first] && std::exchange(seen[cell], 1) == 0; });
    const bool inside = mask[first] != 0;
    // A patch of zeros at the border continues beyond it, where all is 0.
    const bool open =
        !inside && std::ranges::any_of(patch, [&](std::size_t cell) { return near_border(raster, cell, 1); });
    if (patch.size() < kLargePatch && !open) raise_patch(raster, inside, patch, limit, values);
  }
  return values;
}

}  // namespace

DepthField::DepthField(const std::string& path) {
  read_raster(path);
  if (bone_.empty()) return;
  frame_bone();
  exclude_rim_from_holes();
  signed_depth_ = signed_depth(depth_, reamed_);
  extend_depth();
  bone_fraction_ = smoothed_mask(depth_.raster, bone_, std::vector<double>(bone_.size(), 1.0));
  reamed_fraction_ = smoothed_mask(depth_.raster, reamed_, bone_fraction_);
  compute_normals();
  compute_totals();
}

void DepthField::read_raster(const std::string& path) {
  CsvReader table(path, kColumnNames, "the depth_map.csv of a run");
  std::vector<std::array<double, kColumnNames.size()>> rows;
  std::vector<double> xs, ys;
  for (std::vector<double> v; table.next(v, "after_z_mm");) {
    std::copy_n(v.begin(), kColumnNames.size(), rows.emplace_back().begin());
    xs.push_back(v[0]);
    ys.push_back(v[1]);
  }
  if (rows.empty()) return;
  const double step = std::min(least_step(xs), least_step(ys));
  depth_.spacing_mm = std::isfinite(step) ? step : 1;
  depth_.corner_mm = {std::ranges::min(xs), std::ranges::min(ys)};
  const Vec2 last(std::ranges::max(xs), std::ranges::max(ys));
  const Vec2 size = ((last - depth_.corner_mm) / depth_.spacing_mm).array().round() + 1;
  if (size.prod() > kMaxCells) refuse_file(path, "columns do not lie on a regular grid", "the depth_map.csv of a run");
  depth_.raster = {static_cast<int>(size.x()), static_cast<int>(size.y())};
  const std::size_t count = depth_.raster.count();
  depth_.values.assign(count, 0);
  before_mm_.assign(count, 0);
  for (auto* mask : {&bone_, &reamed_, &perforated_}) mask->assign(count, 0);
  for (const auto& [x, y, before_mm, after_mm, depth_mm] : rows) {
    const Vec2 at = ((Vec2(x, y) - depth_.corner_mm) / depth_.spacing_mm).array().round();
    const std::size_t n = depth_.raster.index(static_cast<int>(at.x()), static_cast<int>(at.y()));
    bone_[n] = 1;
    reamed_[n] = depth_mm > 0 ? 1 : 0;
    perforated_[n] = std::isnan(after_mm) ? 1 : 0;
    before_mm_[n] = before_mm;
    depth_.values[n] = depth_mm;
  }
}

/// Without small pieces of bone beside the face, such as a tip of the coracoid: they would make the map smaller.
void DepthField::frame_bone() {
  constexpr double kSpeck_mm2 = 4;
  const Raster& raster = depth_.raster;
  std::vector<std::uint8_t> seen(bone_.size(), 0);
  Eigen::AlignedBox2d columns;
  for (std::size_t first = 0; first < bone_.size(); ++first) {
    if (bone_[first] == 0 || std::exchange(seen[first], 1) != 0) continue;
    std::vector<std::size_t> piece{first};
    flood(raster, piece, [&](std::size_t n) { return bone_[n] != 0 && std::exchange(seen[n], 1) == 0; });
    const bool small = static_cast<double>(piece.size()) * spacing_mm() * spacing_mm() < kSpeck_mm2;
    if (small && std::ranges::none_of(piece, [&](std::size_t n) { return reamed_[n] != 0; })) continue;
    for (const std::size_t n : piece) columns.extend(Vec2(raster.column(n), raster.row(n)));
  }
  const Vec2 half = Vec2::Constant(0.5);
  shown_mm_ = {depth_.corner_mm + spacing_mm() * (columns.min() - half),
               depth_.corner_mm + spacing_mm() * (columns.max() + half)};
}

/// Perforated columns within two columns of the bone's edge, and those connected to them, belong to the rim and not to
/// a hole. The bone's edge is air, or an unreamed column below all that was removed here.
void DepthField::exclude_rim_from_holes() {
  constexpr int kEdgeColumns = 2;
  const Raster& raster = depth_.raster;
  std::vector<std::size_t> rim;
  for (std::size_t n = 0; n < bone_.size(); ++n) {
    if (perforated_[n] == 0) continue;
    const double below_mm = before_mm_[n] - depth_.values[n] - spacing_mm();
    bool near_edge = near_border(raster, n, kEdgeColumns);
    raster.for_each_near(n, kEdgeColumns, [&](std::size_t k) {
      near_edge |= bone_[k] == 0 || (reamed_[k] == 0 && before_mm_[k] < below_mm);
    });
    if (near_edge) rim.push_back(n);
  }
  for (const std::size_t n : rim) perforated_[n] = 0;
  flood(raster, rim, [&](std::size_t n) { return std::exchange(perforated_[n], 0) != 0; });
}

/// Extends the depth by the mean of the nearest reamed columns to where the smoothed outline may reach.
void DepthField::extend_depth() {
  constexpr int kReach = 4;
  constexpr double kSigma = 0.6;  // columns: approximates the nearest of them
  const Raster& raster = depth_.raster;
  const std::vector<double> weights = gaussian(kSigma, kReach);
  for (std::size_t own = 0; own < bone_.size(); ++own) {
    double near_mm = 0, near_weight = 0;
    raster.for_each_near(own, kReach, [&](std::size_t n) {
      if (reamed_[n] == 0) return;
      const int di = raster.column(n) - raster.column(own), dj = raster.row(n) - raster.row(own);
      const double weight =
          weights[static_cast<std::size_t>(di + kReach)] * weights[static_cast<std::size_t>(dj + kReach)];
      near_mm += weight * depth_.values[n];
      near_weight += weight;
    });
    near_mm_.push_back(near_weight > 0 ? near_mm / near_weight : 0);
  }
}

std::vector<ContourLine> DepthField::bone_outlines() const {
  RasterField field = depth_;
  field.values = bone_fraction_;
  return contour_lines(field, 0.5);
}

std::vector<ContourLine> DepthField::reamed_outlines() const {
  RasterField field = depth_;
  for (std::size_t n = 0; n < bone_.size(); ++n) field.values[n] = reamed_fraction_[n] - 0.5 * bone_fraction_[n];
  return contour_lines(field, 0);
}

void DepthField::compute_totals() {
  double sum_mm = 0, columns = 0;
  for (std::size_t n = 0; n < bone_.size(); ++n) {
    if (reamed_[n] == 0) continue;
    deepest_mm_ = std::max(deepest_mm_, depth_.values[n]);
    sum_mm += depth_.values[n];
    ++columns;
    if (perforated_[n] != 0) perforated_mm2_ += spacing_mm() * spacing_mm();
  }
  mean_mm_ = columns > 0 ? sum_mm / columns : 0;
  area_mm2_ = columns * spacing_mm() * spacing_mm();
}

void DepthField::compute_normals() {
  const Raster& raster = depth_.raster;
  const auto bone_at = [&](int i, int j) { return raster.contains(i, j) && bone_[raster.index(i, j)] != 0 ? 1 : 0; };
  // Central differences; one-sided at the bone's edge.
  const auto slope = [&](int i, int j, int di, int dj) {
    const int low = bone_at(i - di, j - dj), high = bone_at(i + di, j + dj);
    if (bone_at(i, j) == 0 || low + high == 0) return 0.0;
    const double rise_mm =
        before_mm_[raster.index(i + high * di, j + high * dj)] - before_mm_[raster.index(i - low * di, j - low * dj)];
    return rise_mm / ((low + high) * spacing_mm());
  };
  for (std::size_t n = 0; n < bone_.size(); ++n) {
    const int i = raster.column(n), j = raster.row(n);
    normals_.push_back(Vec3(-slope(i, j, 1, 0), -slope(i, j, 0, 1), 1).normalized());
  }
}

DepthField::Along DepthField::along(int axis, double place_mm) const {
  const double index = (place_mm - depth_.corner_mm[axis]) / depth_.spacing_mm;
  const double lower = std::floor(index);
  const double high = index - lower;
  return {static_cast<int>(lower), 1 - high, high};
}

template <class Visit>
void DepthField::for_each_corner(const Along& x, const Along& y, const Visit& visit) const {
  const auto at = [&](int i, int j, double weight) {
    if (depth_.raster.contains(i, j)) visit(depth_.raster.index(i, j), weight);
  };
  at(x.column, y.column, x.low * y.low);
  at(x.column + 1, y.column, x.high * y.low);
  at(x.column, y.column + 1, x.low * y.high);
  at(x.column + 1, y.column + 1, x.high * y.high);
}

DepthField::Sample DepthField::at(const Along& x, const Along& y) const {
  Sample out;
  double reamed = 0, near = 0, near_mm = 0;
  for_each_corner(x, y, [&](std::size_t n, double weight) {
    out.bone += weight * bone_fraction_[n];
    out.reamed += weight * reamed_fraction_[n];
    if (perforated_[n] != 0) out.perforated += weight;  // not smoothed: the smallest hole counts
    if (near_mm_[n] > 0) {
      near += weight;
      near_mm += weight * near_mm_[n];
    }
    if (reamed_[n] == 0) return;
    reamed += weight;
    out.depth_mm += weight * depth_.values[n];
    out.smooth_mm += weight * signed_depth_.values[n];
  });
  if (reamed > 0) {
    out.depth_mm /= reamed;
    out.smooth_mm /= reamed;
  } else if (near > 0) {  // the smoothed outline extends beyond the reamed columns
    out.depth_mm = out.smooth_mm = near_mm / near;
  }
  return out;
}

Vec3 DepthField::normal_before(const Along& x, const Along& y) const {
  Vec3 sum = Vec3::Zero();
  for_each_corner(x, y, [&](std::size_t n, double weight) {
    if (bone_[n] != 0) sum += weight * normals_[n];
  });
  return sum.isZero() ? Vec3(Vec3::UnitZ()) : Vec3(sum.normalized());
}

}  // namespace reamsim
