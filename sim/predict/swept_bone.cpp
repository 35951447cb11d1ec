#include "sim/predict/swept_bone.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "sim/base/parallel.h"

namespace reamsim {
namespace {

/// The tool is looked at wherever it turns round, and each time that it may have moved so far, voxels.
constexpr double kStepVoxels = 0.5;
/// It dwells, and does not turn, where it moves by less than this part of such a step.
constexpr double kLeastStep = 0.1;
/// Half a brick's diagonal and a little more than half a voxel's, voxels.
constexpr double kBrickRadiusVoxels = 8;
/// Of the table of distances, voxels.
constexpr double kTablePitchVoxels = 0.5;

/// The tool's signed distance in (r, z) of T, from a table: exact but for a fraction of a voxel at corners.
class DistanceTable {
 public:
  DistanceTable(const Profile& tool, double voxel_mm)
      : pitch_mm_(kTablePitchVoxels * voxel_mm), margin_mm_((kBrickRadiusVoxels + 1) * voxel_mm) {
    const Aabb box = tool.bounds().expanded(margin_mm_);
    low_z_mm_ = box.min.z();
    columns_ = static_cast<int>(std::ceil(box.max.x() / pitch_mm_)) + 2;
    rows_ = static_cast<int>(std::ceil((box.max.z() - low_z_mm_) / pitch_mm_)) + 2;
    mm_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
    parallel_items(static_cast<std::size_t>(rows_), [&](std::size_t row) {
      for (int i = 0; i < columns_; ++i) {
        const Vec2 rz(i * pitch_mm_, low_z_mm_ + static_cast<double>(row) * pitch_mm_);
        mm_[row * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(i)] =
            static_cast<float>(tool.nearest(rz).distance_mm);
      }
    });
  }

  /// Infinity farther away than any voxel of a brick that the tool comes to.
  [[nodiscard]] double at(const Vec3& point_t) const {
    const double r = point_t.head<2>().norm() / pitch_mm_;
    const double z = (point_t.z() - low_z_mm_) / pitch_mm_;
    if (z < 0 || z >= rows_ - 1 || r >= columns_ - 1) return std::numeric_limits<double>::infinity();
    const auto column = static_cast<std::size_t>(r), row = static_cast<std::size_t>(z);
    const double u = r - static_cast<double>(column), v = z - static_cast<double>(row);
    const float* corner = mm_.data() + row * static_cast<std::size_t>(columns_) + column;
    const double low = (1 - u) * double{corner[0]} + u * double{corner[1]};
    const double high = (1 - u) * double{corner[columns_]} + u * double{corner[columns_ + 1]};
    return (1 - v) * low + v * high;
  }
  [[nodiscard]] double margin_mm() const { return margin_mm_; }

 private:
  double pitch_mm_;
  double margin_mm_;
  double low_z_mm_ = 0;
  int columns_ = 0;
  int rows_ = 0;
  std::vector<float> mm_;  ///< row by row, r fastest
};

/// The tool somewhere on its path.
struct Stop {
  Rigid tool_from_bone;
  Aabb box;              ///< of the tool in B, with the table's margin
  std::size_t pose = 0;  ///< the one that it leads to
};

Aabb box_in_bone(const Aabb& box, const Rigid& bone_from_tool) {
  const Vec3 middle = bone_from_tool * Vec3(0.5 * (box.min + box.max));
  const Vec3 half = bone_from_tool.linear().cwiseAbs() * (0.5 * (box.max - box.min));
  return {middle - half, middle + half};
}

bool contains(const Aabb& box, const Vec3& p) {
  return (p.array() >= box.min.array()).all() && (p.array() <= box.max.array()).all();
}

/// Whether the tool stops or turns back at a pose, as it does where it is deepest.
bool turns_at(const std::vector<ToolPose>& poses, std::size_t k) {
  const Vec3 come = poses[k].position_mm - poses[k - 1].position_mm;
  return k + 1 == poses.size() || come.dot(poses[k + 1].position_mm - poses[k].position_mm) <= 0;
}

std::vector<Stop> stops_along(const std::vector<ToolPose>& poses, const Aabb& tool_box, double step_mm) {
  const double reach_mm = tool_box.min.cwiseAbs().cwiseMax(tool_box.max.cwiseAbs()).norm();
  std::vector<Stop> out;
  const auto stop = [&](const ToolPose& pose, std::size_t index) {
    const Rigid bone_from_tool = pose.bone_from_tool();
    out.push_back({bone_from_tool.inverse(), box_in_bone(tool_box, bone_from_tool), index});
  };
  stop(poses.front(), 0);
  const ToolPose* last = &poses.front();
  for (std::size_t k = 1; k < poses.size(); ++k) {
    const double way_mm = (poses[k].position_mm - last->position_mm).norm() +
                          last->orientation.angularDistance(poses[k].orientation) * reach_mm;
    const auto parts = static_cast<std::int64_t>(std::ceil(way_mm / step_mm));
    if (way_mm < kLeastStep * step_mm || (parts == 1 && !turns_at(poses, k))) continue;
    for (std::int64_t i = 1; i < parts; ++i) {
      stop(interpolate(*last, poses[k], static_cast<double>(i) / static_cast<double>(parts)), k);
    }
    stop(poses[k], k);
    last = &poses[k];
  }
  return out;
}

/// A stop that comes near to a brick.
struct NearStop {
  const Stop* stop;
  double middle_mm;  ///< from the tool to the brick's middle
};

/// What one brick of bone loses.
struct BrickLoss {
  Vec3i coord;
  FillBricks::Brick fill;
  std::size_t first_pose;  ///< that removes some of it, to within half a brick
};

/// The bone in the swept volume, brick by brick.
class SweptBone {
 public:
  SweptBone(const Voxmap& voxmap, const FillBricks& before, const Profile& tool, const std::vector<ToolPose>& poses,
            bool whole_voxels)
      : grid_(voxmap.grid),
        grade_(voxmap.grade),
        before_(before),
        whole_voxels_(whole_voxels),
        table_(tool, voxmap.grid.voxel_mm),
        stops_(stops_along(poses, tool.bounds().expanded(table_.margin_mm()), kStepVoxels * voxmap.grid.voxel_mm)) {}

  [[nodiscard]] std::vector<BrickLoss> losses() const {
    std::vector<Vec3i> bricks = grade_.stored_coords();
    Aabb way = stops_.front().box;
    for (const Stop& stop : stops_) way = {way.min.cwiseMin(stop.box.min), way.max.cwiseMax(stop.box.max)};
    std::erase_if(bricks, [&](const Vec3i& coord) { return !contains(way, middle_of(coord)); });
    std::vector<std::optional<BrickLoss>> found(bricks.size());
    parallel_items(bricks.size(), [&](std::size_t i) { found[i] = loss_of(bricks[i]); });
    std::vector<BrickLoss> out;
    for (std::optional<BrickLoss>& loss : found) {
      if (loss) out.push_back(*loss);
    }
    return out;
  }

 private:
  [[nodiscard]] Vec3 middle_of(const Vec3i& brick) const {
    return grid_.origin_mm + grid_.voxel_mm * BrickLattice::kSide * (brick.cast<double>() + Vec3::Constant(0.5));
  }

  [[nodiscard]] std::optional<BrickLoss> loss_of(const Vec3i& coord) const {
    const Vec3 middle = middle_of(coord);
    const double radius_mm = kBrickRadiusVoxels * grid_.voxel_mm;
    std::vector<NearStop> near;
    for (const Stop& stop : stops_) {
      if (!contains(stop.box, middle)) continue;
      const double mm = table_.at(stop.tool_from_bone * middle);
      if (mm < radius_mm) near.push_back({&stop, mm});
    }
    if (near.empty()) return std::nullopt;
    const NearStop& nearest = *std::ranges::min_element(near, {}, &NearStop::middle_mm);
    const double reached_mm = 0.5 * BrickLattice::kSide * grid_.voxel_mm;
    const auto reached = std::ranges::find_if(near, [&](const NearStop& at) { return at.middle_mm < reached_mm; });
    BrickLoss loss{coord, {}, (reached == near.end() ? nearest : *reached).stop->pose};
    return cut(near, nearest.middle_mm < -radius_mm, loss) ? std::optional(loss) : std::nullopt;
  }

  /// Fills in what is left. Returns whether anything is removed.
  bool cut(const std::vector<NearStop>& near, bool whole, BrickLoss& loss) const {
    const GradeBricks::Brick& grades = *grade_.brick(loss.coord);
    const FillBricks::Brick* before = before_.brick(loss.coord);
    bool any = false;
    for (int offset = 0; offset < BrickLattice::kVoxels; ++offset) {
      const auto at = static_cast<std::size_t>(offset);
      std::uint16_t& fill = loss.fill[at];
      fill = before == nullptr ? FillBricks::kWhole : (*before)[at];
      if (grades[at] == 0 || fill == 0) continue;
      const double left = whole ? 0 : fraction_left(BrickLattice::voxel_at(loss.coord, offset), near);
      const auto predicted = static_cast<std::uint16_t>(std::lround(left * double{FillBricks::kWhole}));
      any |= predicted < fill;
      fill = std::min(fill, predicted);
    }
    return any;
  }

  [[nodiscard]] double fraction_left(const Vec3i& voxel, const std::vector<NearStop>& near) const {
    const Vec3 middle = grid_.center_mm(voxel.x(), voxel.y(), voxel.z());
    const double distance = distance_mm(middle, near) / grid_.voxel_mm;
    if (!whole_voxels_) return std::clamp(0.5 + distance, 0.0, 1.0);
    if (std::abs(distance) > 0.5 * std::numbers::sqrt3) return distance > 0 ? 1 : 0;
    for (int i = 0; i < 8; ++i) {
      const Vec3 corner(i & 1, i >> 1 & 1, i >> 2);
      if (distance_mm(middle + grid_.voxel_mm * (corner - Vec3::Constant(0.5)), near) < 0) return 0;
    }
    return 1;
  }

  /// From the nearest of these stops, and at most a voxel.
  [[nodiscard]] double distance_mm(const Vec3& point, const std::vector<NearStop>& near) const {
    double least_mm = grid_.voxel_mm;
    for (const NearStop& at : near) least_mm = std::min(least_mm, table_.at(at.stop->tool_from_bone * point));
    return least_mm;
  }

  const VoxelGrid& grid_;
  const GradeBricks& grade_;
  const FillBricks& before_;
  bool whole_voxels_;
  DistanceTable table_;
  std::vector<Stop> stops_;
};

/// As the log counts depth: along the tool's axis, from where it stood before it first touched.
const ToolPose& deepest_from(const std::vector<ToolPose>& poses, std::size_t contact) {
  const Vec3& start_mm = poses[contact == 0 ? 0 : contact - 1].position_mm;
  const ToolPose* deepest = &poses[contact];
  double most_mm = -std::numeric_limits<double>::infinity();
  for (std::size_t k = contact; k < poses.size(); ++k) {
    const double depth_mm = -(poses[k].position_mm - start_mm).dot(poses[k].orientation * Vec3::UnitZ());
    if (depth_mm <= most_mm) continue;
    most_mm = depth_mm;
    deepest = &poses[k];
  }
  return *deepest;
}

}  // namespace

PredictedBone predict_swept_bone(const Voxmap& voxmap, const FillBricks& before, const Profile& tool,
                                 const std::vector<ToolPose>& poses, bool whole_voxels) {
  PredictedBone out{.fill = before, .deepest = poses.front()};
  std::size_t contact = poses.size();
  for (const BrickLoss& loss : SweptBone(voxmap, before, tool, poses, whole_voxels).losses()) {
    out.fill.put(loss.coord, loss.fill);
    contact = std::min(contact, loss.first_pose);
  }
  if (contact < poses.size()) out.deepest = deepest_from(poses, contact);
  return out;
}

}  // namespace reamsim
