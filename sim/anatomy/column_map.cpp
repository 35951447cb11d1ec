// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/column_map.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "sim/base/parallel.h"

namespace reamsim {

int least_dense_grade(double dense_g_cm3) {
  // A multiple of the grade step, such as 1.0, is not exact in binary.
  constexpr double kSlack = 1e-9;
  return static_cast<int>(std::ceil(dense_g_cm3 / DensityMapping::kGradeStep_g_cm3 - kSlack));
}

BoneFractions::BoneFractions(const BoneView& bone, double dense_g_cm3)
    : bone_(bone),
      voxels_per_mm_(1 / bone.voxmap.grid.voxel_mm),
      bricks_(BrickLattice::over(bone.voxmap.grid.dims)),
      dense_grade_(least_dense_grade(dense_g_cm3)) {}

void BoneFractions::select_brick(const Vec3i& brick) {
  if (brick == view_.coord) return;
  view_ = {.coord = brick};
  if (!bricks_.contains(brick)) return;
  view_.grade = bone_.voxmap.grade.brick(brick);
  view_.before = bone_.fill_before.brick(brick);
  view_.after = bone_.fill.brick(brick);
}

void BoneFractions::add(int offset, double weight, Fractions& sum) const {
  const auto at = static_cast<std::size_t>(offset);
  const int grade = (*view_.grade)[at];
  if (grade == 0) return;
  constexpr double kWhole = FillBricks::kWhole;
  const double after = view_.after == nullptr ? weight : weight * (*view_.after)[at] / kWhole;
  sum.before += view_.before == nullptr ? weight : weight * (*view_.before)[at] / kWhole;
  sum.after += after;
  if (grade >= dense_grade_) sum.dense += after;
}

Fractions BoneFractions::at(const Vec3& point_mm) {
  const Vec3 place = (point_mm - bone_.voxmap.grid.origin_mm) * voxels_per_mm_ - Vec3::Constant(0.5);
  const Vec3 lower = place.array().floor();
  const Vec3i first = lower.cast<int>();
  const Vec3i brick = BrickLattice::brick_of(first);
  const Vec3i local = first - BrickLattice::kSide * brick;
  const bool one_brick = (local.array() < BrickLattice::kSide - 1).all();
  if (one_brick) select_brick(brick);
  Fractions sum;
  for_each_trilinear_weight(place - lower, [&](const Vec3i& step, double weight) {
    if (!one_brick) select_brick(BrickLattice::brick_of(first + step));
    if (view_.grade != nullptr) add(BrickLattice::offset_of(first + step), weight, sum);
  });
  return sum;
}

namespace {

constexpr int kSamplesPerVoxel = 2;   // samples per voxel along a column
constexpr int kReachVoxels = 4;       // columns reach this far above and below the reamed region, voxels
constexpr double kNegligible = 0.02;  // smaller fractions come from interpolation and rounding
constexpr double kHalf = 0.5;
constexpr double kAboveVoxels = 1.5;  // interpolation spreads a surface over a voxel above it
/// A single remaining layer of voxels extends over at most this many voxels after interpolation.
constexpr int kSheetVoxels = 2;

/// The fractions of bone along one column, from the top down, and the surfaces that follow from them.
class ColumnScan {
 public:
  ColumnScan(const BoneView& bone, double top_mm, double bottom_mm)
      : fractions_(bone, DensityMapping::kMaxDensity_g_cm3), voxel_mm_(bone.voxmap.grid.voxel_mm), top_mm_(top_mm) {
    step_mm_ = voxel_mm_ / kSamplesPerVoxel;
    const double steps = std::ceil((top_mm - bottom_mm) / step_mm_);
    before_.resize(static_cast<std::size_t>(steps) + 1);
    after_.resize(before_.size());
  }

  /// The column whose first sample is at `top` of B; `down` has length 1.
  Column scan(const Vec3& top, const Vec3& down) {
    const double bone = sample(top, down);
    // Along a tall core or wall what interpolation takes from the column adds up, though no part of it was removed.
    if (removed_mm_ >= kMinDepthVoxels * voxel_mm_ && largest_cut_ >= kNegligible) return reamed_column();
    const std::size_t deep = fullest(before_, first_bone());
    const double height_mm = surface_above(before_, deep);
    const bool grazed = bone * step_mm_ < kHalf * voxel_mm_;
    return {.state = grazed ? ColumnState::air : ColumnState::bone,
            .before_mm = height_mm,
            .after_mm = height_mm,
            .depth_mm = 0,
            .cover = after_[deep]};
  }

  /// The unreamed surface on the same column.
  std::optional<SurfaceColumn> scan_surface(const Vec3& top, const Vec3& down) {
    const double bone = sample(top, down);
    if (before_.front() > kNegligible || bone * step_mm_ < kHalf * voxel_mm_) return std::nullopt;
    const double height_mm = surface_above(before_, fullest(before_, first_bone()));
    // Interpolated fractions fall to a half at the boundary of the reamed region. Half a voxel below the surface,
    // because in a partly filled voxel of the surface a cut removes nothing until it reaches the bone.
    const Fractions there = fractions_.at(top + (top_mm_ - height_mm + kHalf * voxel_mm_) * down);
    return SurfaceColumn{.height_mm = height_mm, .reamed = there.after < kHalf * there.before};
  }

 private:
  /// Samples a column; returns the sum of the fractions before reaming.
  double sample(const Vec3& top, const Vec3& down) {
    double bone = 0;
    double removed = 0;
    largest_cut_ = 0;
    for (std::size_t i = 0; i < before_.size(); ++i) {
      const Fractions here = fractions_.at(top + static_cast<double>(i) * step_mm_ * down);
      before_[i] = here.before;
      after_[i] = here.after;
      bone += here.before;
      removed += here.before - here.after;
      largest_cut_ = std::max(largest_cut_, here.before - here.after);
    }
    removed_mm_ = removed * step_mm_;
    return bone;
  }

  [[nodiscard]] double height(std::size_t i) const { return top_mm_ - static_cast<double>(i) * step_mm_; }

  /// Height of the surface above sample `deep`, which lies in bone: the integral of the fraction up to the first air.
  [[nodiscard]] double surface_above(const std::vector<double>& fraction, std::size_t deep) const {
    double length_mm = 0.5 * step_mm_ * fraction[deep];
    for (std::size_t i = deep; i-- > 0 && fraction[i] > 1e-6;) length_mm += step_mm_ * fraction[i];
    return height(deep) + length_mm;
  }

  /// The first full sample within `kReachVoxels` below `first`, or else the fullest.
  [[nodiscard]] std::size_t fullest(const std::vector<double>& fraction, std::size_t first) const {
    const std::size_t last = std::min(first + kReachVoxels * kSamplesPerVoxel, fraction.size() - 1);
    std::size_t best = first;
    for (std::size_t i = first; i <= last && fraction[best] < 1 - 1e-6; ++i) {
      if (fraction[i] > fraction[best]) best = i;
    }
    return best;
  }

  [[nodiscard]] std::size_t first_bone() const {
    std::size_t first = 0;
    while (first + 1 < before_.size() && before_[first] < kNegligible) ++first;
    return first;
  }

  /// Whether the bone at sample `deep` is a thin sheet across the column, not a wall that the column grazes.
  [[nodiscard]] bool is_sheet(std::size_t deep) const {
    double length_mm = after_[deep] * step_mm_;
    std::size_t samples = 1;
    for (std::size_t i = deep; i-- > 0 && after_[i] > kNegligible; ++samples) length_mm += after_[i] * step_mm_;
    for (std::size_t i = deep + 1; i < after_.size() && after_[i] > kNegligible; ++i, ++samples) {
      length_mm += after_[i] * step_mm_;
    }
    return samples <= kSheetVoxels * kSamplesPerVoxel && length_mm >= kMinDepthVoxels * voxel_mm_;
  }

  [[nodiscard]] Column reamed_column() const {
    std::size_t last = before_.size() - 1;
    while (last > 0 && before_[last] - after_[last] < kNegligible) --last;
    // The remainder of a partly filled voxel lies slightly above the last trace of removed bone.
    const std::size_t deep = fullest(after_, last - std::min<std::size_t>(last, kSamplesPerVoxel));
    const bool remains = after_[deep] >= kHalf || is_sheet(deep);
    const double after_mm = remains ? surface_above(after_, deep) : height(last);
    return {.state = remains ? ColumnState::reamed : ColumnState::through,
            .before_mm = after_mm + removed_mm_,
            .after_mm = after_mm,
            .depth_mm = removed_mm_,
            .cover = remains ? after_[deep] : 0};
  }

  BoneFractions fractions_;
  double voxel_mm_;
  double top_mm_;
  double step_mm_ = 0;
  double removed_mm_ = 0;   ///< of the last column
  double largest_cut_ = 0;  ///< largest removed fraction of a sample of it
  std::vector<double> before_;
  std::vector<double> after_;
};

}  // namespace

SurfaceProbe probe_surface(const BoneView& bone, const Rigid& bone_from_map, double top_mm, double bottom_mm) {
  return [scan = std::make_shared<ColumnScan>(bone, top_mm, bottom_mm), bone_from_map, top_mm](const Vec2& place_mm) {
    const Vec3 top = bone_from_map * Vec3(place_mm.x(), place_mm.y(), top_mm);
    return scan->scan_surface(top, -bone_from_map.linear().col(2));
  };
}

ColumnMap map_columns(const BoneView& bone, const Rigid& bone_from_map, const MapExtent& extent) {
  ColumnMap map;
  map.bone_from_map = bone_from_map;
  const Rigid map_from_bone = bone_from_map.inverse();
  Aabb box = Aabb::none();  // of the voxels that lost bone
  for_each_cut_voxel(bone, [&](const Vec3i& voxel, std::uint8_t, std::uint16_t, std::uint16_t) {
    box.extend(map_from_bone * bone.voxmap.grid.center_mm(voxel));
  });
  if (box.empty()) return map;
  const double voxel_mm = bone.voxmap.grid.voxel_mm;
  const Vec3 margin = Vec3::Constant(extent.margin_mm + voxel_mm);
  const Vec3 square = Vec3::Constant(extent.radius_mm);
  const Vec3 from = extent.around_axis ? Vec3(-square) : Vec3((box.min - margin).cwiseMin(-square));
  const Vec3 to = extent.around_axis ? square : Vec3((box.max + margin).cwiseMax(square));
  const double least_pitch_mm = extent.pitch_mm > 0 ? extent.pitch_mm : voxel_mm;
  map.pitch_mm = std::max(least_pitch_mm, (to - from).head<2>().maxCoeff() / kMaxColumns);
  // Columns lie at (i + ½)·pitch from the origin of the map.
  const ColumnPlace first = (from.head<2>() / map.pitch_mm).array().floor().cast<int>();
  const ColumnPlace last = (to.head<2>() / map.pitch_mm).array().floor().cast<int>();
  map.nx = last.x() - first.x() + 1;
  map.ny = last.y() - first.y() + 1;
  map.corner_mm = map.pitch_mm * (first.cast<double>() + Vec2::Constant(0.5));
  map.columns.resize(static_cast<std::size_t>(map.nx) * static_cast<std::size_t>(map.ny));

  const double reach_mm = kReachVoxels * voxel_mm;
  const double top_mm = box.max.z() + reach_mm;
  const Vec3 down = -bone_from_map.linear().col(2);
  constexpr std::size_t kColumnsAtOnce = 1024;
  parallel_ranges(map.columns.size(), kColumnsAtOnce, [&](std::size_t begin, std::size_t end) {
    ColumnScan scan(bone, top_mm, box.min.z() - std::max(2 * reach_mm, extent.below_mm));
    for (std::size_t i = begin; i < end; ++i) {
      const int column = static_cast<int>(i);
      map.columns[i] = scan.scan(map.in_bone({column % map.nx, column / map.nx}, top_mm), down);
    }
  });
  return map;
}

ColumnBone::ColumnBone(const BoneView& bone, const ColumnMap& map, double dense_g_cm3)
    : map_(map), fractions_(bone, dense_g_cm3), voxel_mm_(bone.voxmap.grid.voxel_mm) {}

template <class Visit>
void ColumnBone::descend(const ColumnPlace& place, double top_mm, double bottom_mm, const Visit& visit) {
  const double first_mm = top_mm + kAboveVoxels * voxel_mm_;
  const double length_mm = first_mm - bottom_mm;
  if (length_mm <= 0) return;
  const double steps = std::ceil(length_mm * kSamplesPerVoxel / voxel_mm_);
  const double step_mm = length_mm / steps;
  for (double i = 0.5; i < steps; ++i) {
    const double z_mm = first_mm - i * step_mm;
    if (!visit(fractions_.at(map_.in_bone(place, z_mm)), step_mm, top_mm - z_mm)) return;
  }
}

ColumnBone::Length ColumnBone::layer(const ColumnPlace& place, double top_mm, double depth_mm) {
  Length out;
  descend(place, top_mm, top_mm - depth_mm, [&](const Fractions& here, double step_mm, double /*below_mm*/) {
    out.bone_mm += here.after * step_mm;
    out.dense_mm += here.dense * step_mm;
    return true;
  });
  return out;
}

double ColumnBone::largest_fraction(const ColumnPlace& place, double top_mm, double bottom_mm) {
  double largest = 0;
  descend(place, top_mm, bottom_mm, [&](const Fractions& here, double /*step_mm*/, double /*below_mm*/) {
    largest = std::max(largest, here.after);
    return true;
  });
  return largest;
}

double ColumnBone::continuous_mm(const ColumnPlace& place, double top_mm, double bottom_mm, double cover,
                                 double Fractions::*state) {
  const double half = kHalf * cover;
  double length_mm = 0;
  bool inside = false;
  descend(place, top_mm, bottom_mm, [&](const Fractions& here, double step_mm, double below_mm) {
    const double fraction = here.*state;
    inside |= fraction >= half;
    if (!inside && fraction < kNegligible) length_mm = 0;  // bone above a gap
    if (!inside && below_mm > kAboveVoxels * voxel_mm_) return false;
    if (inside && fraction < kNegligible) return false;
    length_mm += fraction * step_mm;
    return true;
  });
  return inside ? length_mm : 0;
}

}  // namespace reamsim
