// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/depth_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

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

/// The mask (1 or 0 per cell), smoothed so that its contour at half of `limit` does not follow the cells' edges.
/// `limit`: the most that a cell can hold, 1 or the smoothed mask that this one is a part of. Isolated patches of a few
/// cells, inside or outside, are kept and become round; spurs one cell wide may vanish.
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

}  // namespace

DepthField::DepthField(const std::string& path) {
  CsvReader table(path, kColumnNames, "the depth_map.csv of a run");
  std::vector<Row> rows;
  for (std::vector<double> v; table.next(v, "after_z_mm");) {
    const Cell cell{.bone = true, .perforated = std::isnan(v[3]), .before_mm = v[2], .depth_mm = v[4]};
    rows.push_back({{v[0], v[1]}, cell});
  }
  if (rows.empty()) return;
  build_raster(rows, path);
  exclude_rim_from_holes();
  smooth();
  smooth_outlines();
  compute_normals();
  compute_totals();
}

void DepthField::build_raster(const std::vector<Row>& rows, const std::string& path) {
  std::vector<double> xs;
  std::vector<double> ys;
  for (const Row& row : rows) {
    xs.push_back(row.place_mm.x());
    ys.push_back(row.place_mm.y());
  }
  const double step = std::min(least_step(xs), least_step(ys));
  spacing_mm_ = std::isfinite(step) ? step : 1;
  corner_mm_ = {*std::min_element(xs.begin(), xs.end()), *std::min_element(ys.begin(), ys.end())};
  const Vec2 last(*std::max_element(xs.begin(), xs.end()), *std::max_element(ys.begin(), ys.end()));
  const Vec2 size = ((last - corner_mm_) / spacing_mm_).array().round() + 1;
  if (size.prod() > kMaxCells) {
    throw InputError({path, 0, 0}, "", "columns do not lie on a regular grid", "the depth_map.csv of a run");
  }
  raster_ = {static_cast<int>(size.x()), static_cast<int>(size.y())};
  cells_.resize(raster_.count());
  for (const Row& row : rows) {
    const Vec2 at = ((row.place_mm - corner_mm_) / spacing_mm_).array().round();
    cells_[raster_.index(static_cast<int>(at.x()), static_cast<int>(at.y()))] = row.cell;
  }
}

/// Perforated columns within two columns of the bone's edge, and those connected to them, belong to the rim and not to
/// a hole. The bone's edge is air, or an unreamed column below all that was removed here.
void DepthField::exclude_rim_from_holes() {
  constexpr int kEdgeColumns = 2;
  std::vector<std::size_t> rim;
  for (std::size_t n = 0; n < cells_.size(); ++n) {
    const Cell& own = cells_[n];
    if (!own.perforated) continue;
    const double below_mm = own.before_mm - own.depth_mm - spacing_mm_;
    const int i = raster_.column(n), j = raster_.row(n);
    bool near_edge =
        !raster_.contains(i - kEdgeColumns, j - kEdgeColumns) || !raster_.contains(i + kEdgeColumns, j + kEdgeColumns);
    raster_.for_each_near(n, kEdgeColumns, [&](std::size_t k) {
      const Cell& near = cells_[k];
      near_edge |= !near.bone || (near.depth_mm <= 0 && near.before_mm < below_mm);
    });
    if (near_edge) rim.push_back(n);
  }
  for (const std::size_t n : rim) cells_[n].perforated = false;
  for (std::size_t k = 0; k < rim.size(); ++k) {
    raster_.for_each_near(rim[k], 1, [&](std::size_t n) {
      if (!cells_[n].perforated) return;
      cells_[n].perforated = false;
      rim.push_back(n);
    });
  }
}

/// Smooths the depth, and extends it by the mean of the nearest reamed columns to where the smoothed outline may reach.
void DepthField::smooth() {
  constexpr int kReach = 4;
  constexpr double kSigma = 0.6;  // columns: approximates the nearest of them
  const std::vector<double> weights = gaussian(kSigma, kReach);
  std::vector<std::uint8_t> reamed;
  for (const Cell& c : cells_) reamed.push_back(c.depth_mm > 0 ? 1 : 0);
  signed_depth_ = signed_depth(field_of([](const Cell& c) { return c.depth_mm; }), reamed);
  for (std::size_t own = 0; own < cells_.size(); ++own) {
    double near_mm = 0, near_weight = 0;
    raster_.for_each_near(own, kReach, [&](std::size_t n) {
      if (reamed[n] == 0) return;
      const int di = raster_.column(n) - raster_.column(own), dj = raster_.row(n) - raster_.row(own);
      const double weight =
          weights[static_cast<std::size_t>(di + kReach)] * weights[static_cast<std::size_t>(dj + kReach)];
      near_mm += weight * cells_[n].depth_mm;
      near_weight += weight;
    });
    cells_[own].smooth_mm = reamed[own] != 0 ? signed_depth_.values[own] : 0;
    cells_[own].near_mm = near_weight > 0 ? near_mm / near_weight : 0;
  }
}

RasterField DepthField::field_of(const std::function<double(const Cell&)>& value) const {
  RasterField out{raster_, corner_mm_, spacing_mm_, {}};
  for (const Cell& c : cells_) out.values.push_back(value(c));
  return out;
}

std::vector<ContourLine> DepthField::bone_outlines() const {
  return contour_lines(field_of([](const Cell& c) { return c.bone_fraction; }), 0.5);
}

std::vector<ContourLine> DepthField::reamed_outlines() const {
  return contour_lines(field_of([](const Cell& c) { return c.reamed_fraction - 0.5 * c.bone_fraction; }), 0);
}

void DepthField::smooth_outlines() {
  std::vector<std::uint8_t> bone, reamed;
  for (const Cell& c : cells_) {
    bone.push_back(c.bone ? 1 : 0);
    reamed.push_back(c.depth_mm > 0 ? 1 : 0);
  }
  const std::vector<double> bone_fraction = smoothed_mask(raster_, bone, std::vector<double>(cells_.size(), 1.0));
  const std::vector<double> reamed_fraction = smoothed_mask(raster_, reamed, bone_fraction);
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    cells_[i].bone_fraction = bone_fraction[i];
    cells_[i].reamed_fraction = reamed_fraction[i];
  }
}

void DepthField::compute_totals() {
  double sum_mm = 0;
  double columns = 0;
  for (const Cell& c : cells_) {
    if (c.depth_mm <= 0) continue;
    deepest_mm_ = std::max(deepest_mm_, c.depth_mm);
    sum_mm += c.depth_mm;
    ++columns;
    if (c.perforated) perforated_mm2_ += spacing_mm_ * spacing_mm_;
  }
  mean_mm_ = columns > 0 ? sum_mm / columns : 0;
  area_mm2_ = columns * spacing_mm_ * spacing_mm_;
}

const DepthField::Cell& DepthField::cell(int i, int j) const {
  return raster_.contains(i, j) ? cells_[raster_.index(i, j)] : outside_;
}

void DepthField::compute_normals() {
  // Central differences; one-sided at the bone's edge.
  const auto slope = [&](const Cell& low, const Cell& own, const Cell& high) {
    const Cell& from = low.bone ? low : own;
    const Cell& to = high.bone ? high : own;
    const int steps = (low.bone ? 1 : 0) + (high.bone ? 1 : 0);
    return own.bone && steps > 0 ? (to.before_mm - from.before_mm) / (steps * spacing_mm_) : 0.0;
  };
  for (std::size_t n = 0; n < cells_.size(); ++n) {
    const int i = raster_.column(n), j = raster_.row(n);
    const Vec3 normal(-slope(cell(i - 1, j), cells_[n], cell(i + 1, j)),
                      -slope(cell(i, j - 1), cells_[n], cell(i, j + 1)), 1);
    cells_[n].normal = normal.normalized();
  }
}

DepthField::Along DepthField::along(int axis, double place_mm) const {
  const double index = (place_mm - corner_mm_[axis]) / spacing_mm_;
  const double lower = std::floor(index);
  const double high = index - lower;
  return {static_cast<int>(lower), 1 - high, high};
}

std::array<DepthField::Corner, 4> DepthField::corners(const Along& x, const Along& y) const {
  const int i = x.column, j = y.column;
  return {{{cell(i, j), x.low * y.low},
           {cell(i + 1, j), x.high * y.low},
           {cell(i, j + 1), x.low * y.high},
           {cell(i + 1, j + 1), x.high * y.high}}};
}

DepthField::Sample DepthField::at(const Along& x, const Along& y) const {
  Sample out;
  double reamed = 0, near = 0, near_mm = 0;
  for (const auto& [c, weight] : corners(x, y)) {
    out.bone += weight * c.bone_fraction;
    out.reamed += weight * c.reamed_fraction;
    if (c.perforated) out.perforated += weight;  // not smoothed: the smallest hole counts
    if (c.near_mm > 0) {
      near += weight;
      near_mm += weight * c.near_mm;
    }
    if (c.depth_mm <= 0) continue;
    reamed += weight;
    out.depth_mm += weight * c.depth_mm;
    out.smooth_mm += weight * c.smooth_mm;
  }
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
  for (const auto& [c, weight] : corners(x, y)) {
    if (c.bone) sum += weight * c.normal;
  }
  return sum.isZero() ? Vec3(Vec3::UnitZ()) : Vec3(sum.normalized());
}

}  // namespace reamsim
