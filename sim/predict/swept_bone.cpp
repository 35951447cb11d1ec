#include "sim/predict/swept_bone.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "kernels/bricks.h"
#include "sim/base/parallel.h"
#include "sim/motion/tool_path.h"
#include "sim/tool/distance_table.h"

namespace reamsim {
namespace {

/// Between two looks at the tool no point of it moves further, voxels.
constexpr double kStepVoxels = 0.5;
/// Of the table of distances, voxels.
constexpr double kTablePitchVoxels = 0.5;

/// Beyond the tool's box, voxels: farther away than any voxel of a brick that the tool comes to.
constexpr double kMarginVoxels = 9;

/// The tool's distances, exact but for a fraction of a voxel at corners.
DistanceTable distances_of(const Profile& tool, double voxel_mm) {
  const double pitch_mm = kTablePitchVoxels * voxel_mm;
  const Aabb box = tool.bounds().expanded(kMarginVoxels * voxel_mm);
  return make_distance_table(tool, {0, box.min.z()}, pitch_mm, static_cast<int>(std::ceil(box.max.x() / pitch_mm)) + 2,
                             static_cast<int>(std::ceil((box.max.z() - box.min.z()) / pitch_mm)) + 2);
}

/// The tool somewhere on its path.
struct Stop {
  Rigid tool_from_bone;
  Aabb box;              ///< of the tool in B, with the margin
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

/// `tool_box`: T, with the margin.
std::vector<Stop> looks_along(const std::vector<ToolPose>& poses, const Aabb& tool_box, double step_mm) {
  const double reach_mm = tool_box.min.cwiseAbs().cwiseMax(tool_box.max.cwiseAbs()).norm();
  std::vector<Stop> out;
  for (const PathStop& stop : stops_along(poses, reach_mm, step_mm)) {
    const Rigid bone_from_tool = stop.pose.bone_from_tool();
    out.push_back({bone_from_tool.inverse(), box_in_bone(tool_box, bone_from_tool), stop.frame});
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
        table_(distances_of(tool, voxmap.grid.voxel_mm)),
        stops_(looks_along(poses, tool.bounds().expanded(kMarginVoxels * voxmap.grid.voxel_mm),
                           kStepVoxels * voxmap.grid.voxel_mm)) {}

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
    const double radius_mm = RS_BRICK_RADIUS * grid_.voxel_mm;
    std::vector<NearStop> near;
    for (const Stop& stop : stops_) {
      if (!contains(stop.box, middle)) continue;
      const double mm = distance_at(stop.tool_from_bone * middle);
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
    const Vec3 middle = grid_.center_mm(voxel);
    const double distance = distance_mm(middle, near) / grid_.voxel_mm;
    if (!whole_voxels_) return std::clamp(0.5 + distance, 0.0, 1.0);
    if (std::abs(distance) > 0.5 * std::numbers::sqrt3) return distance > 0 ? 1 : 0;
    for (int i = 0; i < 8; ++i) {
      const Vec3 corner(i & 1, i >> 1 & 1, i >> 2);
      if (distance_mm(middle + grid_.voxel_mm * (corner - Vec3::Constant(0.5)), near) < 0) return 0;
    }
    return 1;
  }

  [[nodiscard]] double distance_at(const Vec3& point_t) const {
    return table_.at({point_t.head<2>().norm(), point_t.z()});
  }

  /// From the nearest of these stops, and at most a voxel.
  [[nodiscard]] double distance_mm(const Vec3& point, const std::vector<NearStop>& near) const {
    double least_mm = grid_.voxel_mm;
    for (const NearStop& at : near) least_mm = std::min(least_mm, distance_at(at.stop->tool_from_bone * point));
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
