#include "cli/picture_count.h"

#include "sim/scenario/picture_frames.h"

namespace reamsim {

int count_pictures(const ReamingScene& scene) {
  const RenderSettings& render = scene.scenario.render;
  const std::vector<std::int64_t> frames = picture_frames(render, std::ssize(scene.motion.poses) - 1);
  const std::size_t cameras = render.cameras.size() + render.user_cameras.size();
  std::size_t sum = cameras * (1 + still_frames(frames, render).size());
  if (render.before_after) sum += cameras;
  if (render.contact_sheet) ++sum;
  if (render.film != FilmFormat::none) sum += frames.size();
  return static_cast<int>(sum) + render.turntable_pictures;
}

}  // namespace reamsim
