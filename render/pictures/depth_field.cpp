#include "render/pictures/depth_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "render/pictures/soft_outline.h"
#include "sim/base/csv.h"
#include "sim/base/gaussian.h"

namespace reamsim {

namespace {

constexpr std::array<std::string_view, 5> kColumnNames{"x_mm", "y_mm", "before_z_mm", "after_z_mm", "depth_mm"};
/// A raster larger than this is none of ours.
constexpr double kMostCells = 1e8;

/// The least distance between two different values.
double least_step(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double step = values[i] - values[i - 1];
    if (step > 1e-9) least = std::min(least, step);
  }
  return least;
}

}  // namespace

std::vector<DepthField::Row> DepthField::read(const std::string& path) {
  CsvReader table(path, kColumnNames, "the depth_map.csv of a run");
  std::vector<Row> rows;
  for (std::vector<double> v; table.next(v, "after_z_mm");) {
    rows.push_back({{v[0], v[1]}, {.bone = true, .through = std::isnan(v[3]), .before_mm = v[2], .depth_mm = v[4]}});
  }
  return rows;
}

DepthField::DepthField(const std::string& path) {
  const std::vector<Row> rows = read(path);
  if (rows.empty()) return;
  place(rows, path);
  keep_holes();
  smooth();
  round_off();
  find_normals();
  sum_up();
}

void DepthField::place(const std::vector<Row>& rows, const std::string& path) {
  std::vector<double> xs;
  std::vector<double> ys;
  for (const Row& row : rows) {
    xs.push_back(row.place_mm.x());
    ys.push_back(row.place_mm.y());
  }
  const double step = std::min(least_step(xs), least_step(ys));
  pitch_mm_ = std::isfinite(step) ? step : 1;
  corner_mm_ = {*std::min_element(xs.begin(), xs.end()), *std::min_element(ys.begin(), ys.end())};
  const Vec2 last(*std::max_element(xs.begin(), xs.end()), *std::max_element(ys.begin(), ys.end()));
  const Vec2 size = ((last - corner_mm_) / pitch_mm_).array().round() + 1;
  if (size.prod() > kMostCells) {
    throw InputError({path, 0, 0}, "", "columns do not lie on a regular grid", "the depth_map.csv of a run");
  }
  nx_ = static_cast<int>(size.x());
  ny_ = static_cast<int>(size.y());
  cells_.resize(static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_));
  for (const Row& row : rows) {
    const Vec2 at = ((row.place_mm - corner_mm_) / pitch_mm_).array().round();
    cells_[index(static_cast<int>(at.x()), static_cast<int>(at.y()))] = row.cell;
  }
}

/// Columns reamed through that are joined to the bone's edge, or come within two columns of it, are its rim; the bone
/// ends in air, or where what is beside was not reamed and lies below all that the column lost.
void DepthField::keep_holes() {
  constexpr int kEdge = 2;
  const auto at = [&](int i, int j) -> Cell& { return cells_[index(i, j)]; };
  std::vector<std::pair<int, int>> rim;
  const auto look_round = [&](int i, int j, int reach, const auto& visit) {
    for (int b = j - reach; b <= j + reach; ++b) {
      for (int a = i - reach; a <= i + reach; ++a) visit(a, b);
    }
  };
  for (int j = 0; j < ny_; ++j) {
    for (int i = 0; i < nx_; ++i) {
      const Cell& own = at(i, j);
      if (!own.through) continue;
      const double below_mm = own.before_mm - own.depth_mm - pitch_mm_;
      bool edge_near = false;
      look_round(i, j, kEdge, [&](int a, int b) {
        const Cell& beside = cell(a, b);
        edge_near |= !beside.bone || (beside.depth_mm <= 0 && beside.before_mm < below_mm);
      });
      if (edge_near) rim.emplace_back(i, j);
    }
  }
  for (const auto& [i, j] : rim) at(i, j).through = false;
  for (std::size_t k = 0; k < rim.size(); ++k) {
    const auto [i, j] = rim[k];
    look_round(i, j, 1, [&](int a, int b) {
      if (!cell(a, b).through) return;
      at(a, b).through = false;  // so that it is queued only once
      rim.emplace_back(a, b);
    });
  }
}

/// A Gaussian over the reamed columns: steps of whole voxels would make contour lines of every grain. And a far
/// narrower one, which is next to what the nearest of them has.
void DepthField::smooth() {
  constexpr int kReach = 4;
  constexpr double kSigma = 1.8;   // columns
  constexpr double kNarrower = 9;  // its variance, as a part of the other's
  const std::vector<double> weights = gaussian(kSigma, kReach);
  for (int j = 0; j < ny_; ++j) {
    for (int i = 0; i < nx_; ++i) {
      double sum_mm = 0;
      double sum_weight = 0;
      double near_mm = 0;
      double near_weight = 0;
      for (int n = 0; n < (2 * kReach + 1) * (2 * kReach + 1); ++n) {
        const int di = n % (2 * kReach + 1);
        const int dj = n / (2 * kReach + 1);
        const Cell& its = cell(i + di - kReach, j + dj - kReach);
        if (its.depth_mm <= 0) continue;
        const double weight = weights[static_cast<std::size_t>(di)] * weights[static_cast<std::size_t>(dj)];
        sum_mm += weight * its.depth_mm;
        sum_weight += weight;
        near_mm += std::pow(weight, kNarrower) * its.depth_mm;
        near_weight += std::pow(weight, kNarrower);
      }
      Cell& own = cells_[index(i, j)];
      own.smooth_mm = sum_weight > 0 ? sum_mm / sum_weight : 0;
      own.near_mm = near_weight > 0 ? near_mm / near_weight : 0;
    }
  }
}

void DepthField::round_off() {
  CellMask bone{nx_, ny_, {}};
  CellMask reamed{nx_, ny_, {}};
  for (const Cell& its : cells_) {
    bone.in.push_back(its.bone ? 1 : 0);
    reamed.in.push_back(its.depth_mm > 0 ? 1 : 0);
  }
  const std::vector<double> of_bone = soft_outline(bone, std::vector<double>(cells_.size(), 1.0));
  const std::vector<double> of_reamed = soft_outline(reamed, of_bone);
  for (std::size_t i = 0; i < cells_.size(); ++i) cells_[i].shares = {of_bone[i], of_reamed[i]};
}

void DepthField::sum_up() {
  double sum_mm = 0;
  double columns = 0;
  for (const Cell& its : cells_) {
    if (its.depth_mm <= 0) continue;
    deepest_mm_ = std::max(deepest_mm_, its.depth_mm);
    sum_mm += its.depth_mm;
    ++columns;
    if (its.through) through_mm2_ += pitch_mm_ * pitch_mm_;
  }
  mean_mm_ = columns > 0 ? sum_mm / columns : 0;
  area_mm2_ = columns * pitch_mm_ * pitch_mm_;
}

const DepthField::Cell& DepthField::cell(int i, int j) const {
  static const Cell outside;
  if (i < 0 || j < 0 || i >= nx_ || j >= ny_) return outside;
  return cells_[index(i, j)];
}

void DepthField::find_normals() {
  // At the bone's edge by the one side that has bone.
  const auto slope = [&](const Cell& low, const Cell& own, const Cell& high) {
    const Cell& from = low.bone ? low : own;
    const Cell& to = high.bone ? high : own;
    const int steps = (low.bone ? 1 : 0) + (high.bone ? 1 : 0);
    return own.bone && steps > 0 ? (to.before_mm - from.before_mm) / (steps * pitch_mm_) : 0.0;
  };
  for (int j = 0; j < ny_; ++j) {
    for (int i = 0; i < nx_; ++i) {
      const Cell& own = cell(i, j);
      const Vec3 normal(-slope(cell(i - 1, j), own, cell(i + 1, j)), -slope(cell(i, j - 1), own, cell(i, j + 1)), 1);
      cells_[index(i, j)].normal = normal.normalized();
    }
  }
}

std::array<DepthField::Corner, 4> DepthField::corners(const Vec2& place_mm) const {
  const Vec2 index = (place_mm - corner_mm_) / pitch_mm_;
  const Vec2 lower = index.array().floor();
  const Vec2 high = index - lower;
  const Vec2 low = Vec2::Ones() - high;
  const int i = static_cast<int>(lower.x()), j = static_cast<int>(lower.y());
  return {{{cell(i, j), low.x() * low.y()},
           {cell(i + 1, j), high.x() * low.y()},
           {cell(i, j + 1), low.x() * high.y()},
           {cell(i + 1, j + 1), high.x() * high.y()}}};
}

DepthField::Sample DepthField::at(const Vec2& place_mm) const {
  Sample out;
  double reamed = 0;
  double near = 0;
  double near_mm = 0;
  for (const auto& [its, weight] : corners(place_mm)) {
    out.bone += weight * its.shares.bone;
    out.reamed += weight * its.shares.reamed;
    if (its.through) out.through += weight;  // as it is: the smallest hole counts
    if (its.near_mm > 0) {
      near += weight;
      near_mm += weight * its.near_mm;
    }
    if (its.depth_mm <= 0) continue;
    reamed += weight;
    out.depth_mm += weight * its.depth_mm;
    out.smooth_mm += weight * its.smooth_mm;
  }
  if (reamed > 0) {
    out.depth_mm /= reamed;
    out.smooth_mm /= reamed;
  } else if (near > 0) {  // where the outline leaves the reamed columns
    out.depth_mm = out.smooth_mm = near_mm / near;
  }
  return out;
}

Vec3 DepthField::normal_before(const Vec2& place_mm) const {
  Vec3 sum = Vec3::Zero();
  for (const auto& [its, weight] : corners(place_mm)) {
    if (its.bone) sum += weight * its.normal;
  }
  return sum.isZero() ? Vec3(Vec3::UnitZ()) : Vec3(sum.normalized());
}

}  // namespace reamsim
