#include "sim/metrics/column_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace reamsim {

namespace {

/// Samples per voxel along a column.
constexpr int kSamplesPerVoxel = 2;
/// Bone is looked for this far above and below what was reamed, voxels.
constexpr int kReachVoxels = 4;
/// Fractions below this are the blur of interpolation and rounding.
constexpr double kNegligible = 0.02;
constexpr double kHalf = 0.5;
/// What is left of a single layer of voxels shows, with the interpolation's blur, over no more voxels than this.
constexpr int kSheetVoxels = 2;

/// The box of the voxels that lost bone, in the map's frame; empty when none did.
Aabb box_of_cut(const ReamedBone& bone, const Rigid& map_from_bone) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Aabb box{Vec3::Constant(kFar), Vec3::Constant(-kFar)};
  const VoxelGrid& grid = bone.voxmap.grid;
  for_each_cut_voxel(bone, [&](const Vec3i& voxel, std::uint8_t, std::uint16_t, std::uint16_t) {
    const Vec3 place = map_from_bone * grid.center_mm(voxel);
    box.min = box.min.cwiseMin(place);
    box.max = box.max.cwiseMax(place);
  });
  return box;
}

}  // namespace

/// One column's shares from above to below, and what they say.
class ColumnScan {
 public:
  ColumnScan(const ReamedBone& bone, double top_mm, double bottom_mm)
      : fractions_(bone, DensityMapping::kMaxDensity_g_cm3), voxel_mm_(bone.voxmap.grid.voxel_mm), top_mm_(top_mm) {
    step_mm_ = voxel_mm_ / kSamplesPerVoxel;
    const double steps = std::ceil((top_mm - bottom_mm) / step_mm_);
    before_.resize(static_cast<std::size_t>(steps) + 1);
    after_.resize(before_.size());
  }

  /// The column whose highest sample is at `top` of B; `down` has length 1.
  Column scan(const Vec3& top, const Vec3& down) {
    const double bone = sample(top, down);
    Column out;
    out.depth_mm = removed_mm_;
    if (out.depth_mm >= kMinDepthVoxels * voxel_mm_) {
      measure_reamed(out);
    } else if (bone * step_mm_ >= kHalf * voxel_mm_) {
      const double height_mm = top_surface();
      out = {.state = ColumnState::bone, .before_mm = height_mm, .after_mm = height_mm, .depth_mm = 0};
    } else {
      out = {};
    }
    return out;
  }

  /// What the same column shows of the unreamed bone.
  std::optional<SurfaceColumn> scan_surface(const Vec3& top, const Vec3& down) {
    const double bone = sample(top, down);
    if (before_.front() > kNegligible || bone * step_mm_ < kHalf * voxel_mm_) return std::nullopt;
    const double height_mm = top_surface();
    // Blurred as shares are, half of them stands where the limit of what was reamed does. Not in the surface's own
    // voxels: there a cut takes nothing before it leaves less than there was.
    const Fractions there = fractions_.at(top + (top_mm_ - height_mm + kHalf * voxel_mm_) * down);
    return SurfaceColumn{.height_mm = height_mm, .reamed = there.after < kHalf * there.before};
  }

 private:
  /// Reads the shares along a column; returns the sum of the bone's before.
  double sample(const Vec3& top, const Vec3& down) {
    double bone = 0;
    double gone = 0;
    for (std::size_t i = 0; i < before_.size(); ++i) {
      const Fractions here = fractions_.at(top + static_cast<double>(i) * step_mm_ * down);
      before_[i] = here.before;
      after_[i] = here.after;
      bone += here.before;
      gone += here.before - here.after;
    }
    removed_mm_ = gone * step_mm_;
    return bone;
  }

  [[nodiscard]] double gone(std::size_t i) const { return before_[i] - after_[i]; }
  [[nodiscard]] double height(std::size_t i) const { return top_mm_ - static_cast<double>(i) * step_mm_; }

  /// Height of the surface above sample `deep`, which lies in bone: what of the bone's share is found above it, up to
  /// the first air.
  [[nodiscard]] double surface_above(const std::vector<double>& fraction, std::size_t deep) const {
    double length_mm = 0.5 * step_mm_ * fraction[deep];
    for (std::size_t i = deep; i-- > 0 && fraction[i] > 1e-6;) length_mm += step_mm_ * fraction[i];
    return height(deep) + length_mm;
  }

  /// The fullest sample of the first `kReachVoxels` from `first` down, or the first full one.
  [[nodiscard]] std::size_t fullest(const std::vector<double>& fraction, std::size_t first) const {
    const std::size_t last = std::min(first + kReachVoxels * kSamplesPerVoxel, fraction.size() - 1);
    std::size_t best = first;
    for (std::size_t i = first; i <= last && fraction[best] < 1 - 1e-6; ++i) {
      if (fraction[i] > fraction[best]) best = i;
    }
    return best;
  }

  [[nodiscard]] double top_surface() const {
    std::size_t first = 0;
    while (first + 1 < before_.size() && before_[first] < kNegligible) ++first;
    return surface_above(before_, fullest(before_, first));
  }

  /// Whether the bone round sample `deep` is a thin sheet across the column: then its share is small because it is
  /// thin, and not because the column grazes a wall.
  [[nodiscard]] bool is_sheet(std::size_t deep) const {
    double length_mm = after_[deep] * step_mm_;
    std::size_t samples = 1;
    for (std::size_t i = deep; i-- > 0 && after_[i] > kNegligible; ++samples) length_mm += after_[i] * step_mm_;
    for (std::size_t i = deep + 1; i < after_.size() && after_[i] > kNegligible; ++i, ++samples) {
      length_mm += after_[i] * step_mm_;
    }
    return samples <= kSheetVoxels * kSamplesPerVoxel && length_mm >= kMinDepthVoxels * voxel_mm_;
  }

  void measure_reamed(Column& out) const {
    std::size_t last = before_.size() - 1;
    while (last > 0 && gone(last) < kNegligible) --last;
    // What is left of a partly filled voxel lies a little above the last trace of what went.
    const std::size_t deep = fullest(after_, last - std::min<std::size_t>(last, kSamplesPerVoxel));
    const bool bone_left = after_[deep] >= kHalf || is_sheet(deep);
    out.state = bone_left ? ColumnState::reamed : ColumnState::through;
    out.after_mm = bone_left ? surface_above(after_, deep) : height(last);
    out.before_mm = out.after_mm + out.depth_mm;
  }

  BoneFractions fractions_;
  double voxel_mm_;
  double top_mm_;
  double step_mm_ = 0;
  double removed_mm_ = 0;  ///< of the column that was sampled last
  std::vector<double> before_;
  std::vector<double> after_;
};

namespace {

/// Columns stand at (i + ½)·pitch from the map's origin; the least and the last i for a stretch, both inside.
std::pair<int, int> columns_over(double from_mm, double to_mm, double pitch_mm) {
  return {static_cast<int>(std::floor(from_mm / pitch_mm)), static_cast<int>(std::floor(to_mm / pitch_mm))};
}

}  // namespace

SurfaceProbe::SurfaceProbe(const ReamedBone& bone, const Rigid& bone_from_map, double top_mm, double bottom_mm)
    : scan_(std::make_unique<ColumnScan>(bone, top_mm, bottom_mm)), bone_from_map_(bone_from_map), top_mm_(top_mm) {}

SurfaceProbe::~SurfaceProbe() = default;

std::optional<SurfaceColumn> SurfaceProbe::at(const Vec2& place_mm) {
  const Vec3 top = bone_from_map_ * Vec3(place_mm.x(), place_mm.y(), top_mm_);
  return scan_->scan_surface(top, -bone_from_map_.linear().col(2));
}

ColumnMap map_columns(const ReamedBone& bone, const Rigid& bone_from_map, const MapExtent& room) {
  ColumnMap map;
  map.bone_from_map = bone_from_map;
  const Aabb box = box_of_cut(bone, bone_from_map.inverse());
  if (box.empty()) return map;
  const double voxel_mm = bone.voxmap.grid.voxel_mm;
  const Vec3 margin = Vec3::Constant(room.margin_mm + voxel_mm);
  const Vec3 from = (box.min - margin).cwiseMin(-room.radius_mm);
  const Vec3 to = (box.max + margin).cwiseMax(room.radius_mm);
  map.pitch_mm = std::max(voxel_mm, (to - from).head<2>().maxCoeff() / kMaxColumns);
  const auto [first_x, last_x] = columns_over(from.x(), to.x(), map.pitch_mm);
  const auto [first_y, last_y] = columns_over(from.y(), to.y(), map.pitch_mm);
  map.nx = last_x - first_x + 1;
  map.ny = last_y - first_y + 1;
  map.corner_mm = map.pitch_mm * Vec2(first_x + 0.5, first_y + 0.5);
  map.columns.resize(static_cast<std::size_t>(map.nx) * static_cast<std::size_t>(map.ny));

  const double reach_mm = kReachVoxels * voxel_mm;
  const double top_mm = box.max.z() + reach_mm;
  ColumnScan scan(bone, top_mm, box.min.z() - 2 * reach_mm);
  const Vec3 down = -bone_from_map.linear().col(2);
  for (int j = 0; j < map.ny; ++j) {
    for (int i = 0; i < map.nx; ++i) {
      map.columns[static_cast<std::size_t>(i) + static_cast<std::size_t>(map.nx) * static_cast<std::size_t>(j)] =
          scan.scan(map.in_bone(i, j, top_mm), down);
    }
  }
  return map;
}

}  // namespace reamsim
