#include "sim/scenario/picture_frames.h"

#include <algorithm>

namespace reamsim {
namespace {

constexpr std::size_t kStillsBesideFilm = 11;

}  // namespace

std::vector<std::int64_t> picture_frames(const RenderSettings& settings, std::int64_t last) {
  constexpr std::int64_t kPictures = 10;
  constexpr std::int64_t kFilmPictures = 150;
  const std::int64_t pictures = settings.enabled && settings.film != FilmFormat::none ? kFilmPictures : kPictures;
  const std::int64_t spread = std::max<std::int64_t>(1, (last + pictures - 1) / pictures);
  const std::int64_t interval = settings.every_frames > 0 ? settings.every_frames : spread;
  std::vector<std::int64_t> out;
  for (std::int64_t frame = 0; frame < last; frame += interval) out.push_back(frame);
  out.push_back(last);
  return out;
}

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
  return settings.film != FilmFormat::none && settings.every_frames == 0 ? evenly_among(frames, kStillsBesideFilm)
                                                                         : frames;
}

}  // namespace reamsim
