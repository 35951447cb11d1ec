// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <vector>

#include "sim/engine/common/substep.h"
#include "sim/engine/exact/brick_batch_plan.h"
#include "sim/run/cost_estimate.h"
#include "sim/tool/tool_path.h"

namespace reamsim {

namespace {

/// Motion of the tool between two tested poses, voxels.
constexpr double kStepVoxels = 2;
enum class BrickMark : std::uint8_t { air, whole, partial };

/// Bound of the tool's motion in a visit, mm.
double visit_shift(const SimulationInput& scene) {
  const double voxel_mm = scene.bone.voxmap->grid.voxel_mm;
  double substep_mm = 0;
  const auto& poses = scene.motion.poses;
  for (std::size_t k = 1; k < poses.size(); ++k) {
    substep_mm = std::max(substep_mm, motion_bound_mm(poses[k - 1], poses[k], scene.tool.reach_mm));
  }
  substep_mm = std::min(substep_mm, scene.scenario.engine.max_step_voxels * voxel_mm);
  return std::min(RS_VISIT_SUBSTEPS * substep_mm, kVisitShiftVoxels * voxel_mm);
}

/// Bound of the distance between a point and its sample, mm.
double sample_slack(const DistanceTable& table) {
  return std::sqrt(0.5) * table.pitch_mm + 1e-3;
}

/// Bricks of the lattice, and those that the tool has reached.
class SweptBricks {
 public:
  explicit SweptBricks(const SimulationInput& scene)
      : scene_(scene),
        visit_shift_mm_(visit_shift(scene)),
        voxel_mm_(scene.bone.voxmap->grid.voxel_mm),
        lattice_(BrickLattice::over(scene.bone.voxmap->grid.dims)),
        marks_(lattice_.count(), BrickMark::air),
        bone_(bone_extent(*scene.bone.voxmap)),
        coarse_(brick_distances(scene.tool.profile, voxel_mm_, scene.tool.clip_slack_mm())) {
    const Voxmap& voxmap = *scene.bone.voxmap;
    voxmap.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick&) {
      const bool partial = scene.bone.fill.brick(coord) != nullptr;
      marks_[lattice_.index(coord)] = partial ? BrickMark::partial : BrickMark::whole;
      out_.partial += partial ? 1 : 0;
    });
  }

  /// Adds the bricks that the tool reaches within `slack_mm` of a pose.
  void add(const ToolPose& pose, double slack_mm) {
    const Substep rest{.pose = pose, .duration_s = scene_.motion.frame_s()};
    const double reached_mm = RS_BRICK_RADIUS * voxel_mm_ + slack_mm;
    const double listed_mm = reached_mm + visit_shift_mm_ + sample_slack(coarse_);
    const Aabb box = scene_.tool.clip_bounds().expanded(listed_mm);
    const SubstepArgs args =
        make_args(rest, box, scene_.tool.shell, scene_.bone.voxmap->grid, scene_.scenario.cutting, false);
    const VoxelBox near = voxel_voi(args, box, bone_);
    if (near.empty()) return;
    const Vec3i first = near.first / BrickLattice::kSide, last = near.last / BrickLattice::kSide;
    std::size_t listed = 0;
    for (int z = first.z(); z <= last.z(); ++z) {
      for (int y = first.y(); y <= last.y(); ++y) {
        for (int x = first.x(); x <= last.x(); ++x) {
          BrickMark& mark = marks_[lattice_.index({x, y, z})];
          if (mark == BrickMark::air) continue;
          const double distance_mm = distance(args, {x, y, z}, reached_mm);
          listed += std::abs(distance_mm) <= listed_mm ? 1 : 0;
          if (distance_mm > reached_mm || mark == BrickMark::partial) continue;
          ++out_.partial;
          mark = BrickMark::partial;
        }
      }
    }
    out_.listed = std::max(out_.listed, listed);
  }

  [[nodiscard]] const ExactForecast& forecast() const { return out_; }

 private:
  /// Signed distance of a brick's middle from the tool's surface, mm: that of the profile close to `limit_mm`, that of
  /// the coarse table elsewhere.
  [[nodiscard]] double distance(const SubstepArgs& args, const Vec3i& brick, double limit_mm) const {
    const Vec3 middle = (BrickLattice::kSide * brick).cast<double>() + Vec3::Constant(0.5 * (BrickLattice::kSide - 1));
    const Mat3 tool_from_voxel = Eigen::Map<const Mat3>(args.tool_from_voxel).transpose();  // stored row by row
    const Vec3 p = tool_from_voxel * middle + Eigen::Map<const Vec3>(args.tool_origin);
    const Vec2 rz(p.head<2>().norm(), p.z());
    const double coarse = coarse_.nearest(rz);
    return std::abs(coarse - limit_mm) > sample_slack(coarse_) ? coarse : scene_.tool.profile.nearest(rz).distance_mm;
  }

  const SimulationInput& scene_;
  double visit_shift_mm_;
  double voxel_mm_;
  BrickLattice lattice_;
  std::vector<BrickMark> marks_;
  VoxelBox bone_;
  DistanceTable coarse_;
  ExactForecast out_;
};

}  // namespace

ExactForecast forecast_exact(const SimulationInput& scene) {
  SweptBricks swept(scene);
  BoundedPath path(scene.tool.reach_mm, kStepVoxels * scene.bone.voxmap->grid.voxel_mm);
  path.add(scene.motion.poses);
  const double step_mm = path.step_mm();
  for (const PathSample& sample : sample_path(path.finish(), scene.tool.reach_mm, step_mm)) {
    swept.add(sample.pose, step_mm + path.deviation_mm());
  }
  return swept.forecast();
}

}  // namespace reamsim
