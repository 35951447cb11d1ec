#include "render/picture_frames.h"

#include <algorithm>

namespace reamsim {
namespace {

constexpr std::size_t kStillsBesideFilm = 11;

}  // namespace

std::vector<std::int64_t> evenly_among(const std::vector<std::int64_t>& frames, std::size_t most) {
  const std::size_t count = std::min(frames.size(), most);
  if (count < 2) return frames;
  std::vector<std::int64_t> out;
  for (std::size_t i = 0; i < count; ++i) {
    out.push_back(frames[(2 * i * (frames.size() - 1) + count - 1) / (2 * (count - 1))]);
  }
  return out;
}

std::vector<std::int64_t> still_frames(const std::vector<std::int64_t>& frames, const RenderSettings& settings) {
  return settings.film != "none" && settings.every_frames == 0 ? evenly_among(frames, kStillsBesideFilm) : frames;
}

}  // namespace reamsim
