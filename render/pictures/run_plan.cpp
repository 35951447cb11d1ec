#include "render/pictures/run_plan.h"

#include <algorithm>

namespace reamsim {

const ToolPose& RunPlan::pose_at(std::int64_t frame) const {
  const auto after = std::ranges::upper_bound(pose_frames, frame);
  return after == pose_frames.begin() ? poses.front()
                                      : poses[static_cast<std::size_t>(after - pose_frames.begin()) - 1];
}

FillBricks with_gone_voxels_whole(const FillBricks& fill) {
  FillBricks out = fill;
  fill.for_each_brick([&](const Vec3i& coord, const FillBricks::Brick& brick) {
    FillBricks::Brick whole = brick;
    std::replace(whole.begin(), whole.end(), std::uint16_t{0}, FillBricks::kWhole);
    out.put(coord, whole);
  });
  return out;
}

}  // namespace reamsim
