// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cmath>
#include <limits>

#include "sim/tool/tool_path.h"
#include "tests/engine/scene_fixture.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {

/// The volume that an envelope of revolution sweeps along a motion, by analysis of its profile alone: no shell, no
/// voxels. The motion is sampled so finely that it does not matter.
class SweptVolume {
 public:
  /// No point of the tool moves further than `step_mm` from one sample to the next.
  SweptVolume(const Motion& motion, const Profile& profile, double step_mm)
      : profile_(profile), radius_mm_(profile.max_radius_mm()) {
    for (const Vec2& p : profile.points) {
      bottom_mm_ = std::min(bottom_mm_, p.y());
      top_mm_ = std::max(top_mm_, p.y());
    }
    std::vector<PathSample> path;
    for (std::size_t k = 0; k < motion.poses.size(); ++k) path.push_back({motion.poses[k], k});
    for (const PathSample& sample : sample_path(path, profile.bounds().max.norm(), step_mm)) {
      tool_from_bone_.push_back(sample.pose.bone_from_tool().inverse());
    }
  }

  /// How deep a point of B came to lie inside the envelope, mm: the greatest depth over the samples, or the first one
  /// beyond `enough_mm`. Negative: never inside.
  [[nodiscard]] double depth_mm(const Vec3& point, double enough_mm) const {
    double depth = -std::numeric_limits<double>::infinity();
    for (const Rigid& pose : tool_from_bone_) {
      const Vec3 p = pose * point;
      const double r = std::hypot(p.x(), p.y());
      if (r > radius_mm_ || p.z() < bottom_mm_ || p.z() > top_mm_) continue;
      depth = std::max(depth, -profile_.nearest({r, p.z()}).distance_mm);
      if (depth > enough_mm) break;
    }
    return depth;
  }

 private:
  const Profile& profile_;
  double radius_mm_;
  double bottom_mm_ = std::numeric_limits<double>::infinity();
  double top_mm_ = -std::numeric_limits<double>::infinity();
  std::vector<Rigid> tool_from_bone_;
};

/// What a run left of the voxels that its tool swept.
struct Leftovers {
  std::int64_t swept = 0;     ///< voxels whose centres lay deeper inside the tool than asked
  std::int64_t left = 0;      ///< of these, how many are still bone
  double deepest_voxels = 0;  ///< how deep the deepest of those lay
};

/// Reams the scene, and looks for bone whose voxel centres lay more than `deeper_than_voxels` inside the swept volume,
/// which is sampled every `step_voxels`.
inline Leftovers ream_and_look(SimulationInput& scene, double deeper_than_voxels, double step_voxels = 0.05) {
  Leftovers out;
  {
    const TempDir dir;
    Diagnostics report;
    Recorder recorder(dir.path(), scene.bone.voxmap->grid.voxel_mm);
    const auto engine = make_engine(scene.scenario, scene.bone, scene.tool);
    simulate(scene, *engine, recorder, {}, report);
    recorder.close();
  }
  const VoxelGrid& grid = scene.bone.voxmap->grid;
  const SweptVolume volume(scene.motion, scene.tool.profile, step_voxels * grid.voxel_mm);
  const double limit_mm = deeper_than_voxels * grid.voxel_mm;
  for (std::int64_t e = 0; e < grid.size(); ++e) {
    const Vec3i c = grid.coord(e);
    const bool removed = scene.bone.fill.get(c) == 0;
    const double depth_mm =
        volume.depth_mm(grid.center_mm(c), removed ? limit_mm : std::numeric_limits<double>::infinity());
    if (depth_mm <= limit_mm) continue;
    ++out.swept;
    if (removed) continue;
    ++out.left;
    out.deepest_voxels = std::max(out.deepest_voxels, depth_mm / grid.voxel_mm);
  }
  return out;
}

}  // namespace reamsim::test
