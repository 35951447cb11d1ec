#include "sim/scenario/picture_frames.h"

#include <algorithm>

namespace reamsim {
namespace {

/// Of a run whose settings give no number, the first and the last included.
constexpr std::int64_t kStills = 11;
constexpr std::int64_t kFilmPictures = 150;
/// Margin around the contact, parts of it: 1/20.
constexpr std::int64_t kMarginParts = 20;

void sort_once(std::vector<std::int64_t>& frames) {
  std::ranges::sort(frames);
  const auto repeated = std::ranges::unique(frames);
  frames.erase(repeated.begin(), repeated.end());
}

/// 0, `last`, and between them as many in contact as make the number of stills.
std::vector<std::int64_t> spread_over(const FrameSpan& contact, std::int64_t last) {
  const std::int64_t first = std::clamp<std::int64_t>(contact.first, 0, last);
  const std::int64_t end = std::clamp(contact.last, first, last);
  const std::int64_t steps = kStills - (first > 0 ? 1 : 0) - (end < last ? 1 : 0) - 1;
  std::vector<std::int64_t> out{0, last};
  for (std::int64_t i = 0; i <= steps; ++i) out.push_back(first + (2 * i * (end - first) + steps) / (2 * steps));
  sort_once(out);
  return out;
}

}  // namespace

std::vector<std::int64_t> picture_frames(const RenderSettings& settings, std::int64_t last,
                                         const std::optional<FrameSpan>& contact) {
  const bool film = settings.enabled && settings.film != FilmFormat::none;
  if (settings.every_frames == 0 && !film && contact) return spread_over(*contact, last);
  const std::int64_t pictures = film ? kFilmPictures : kStills - 1;
  const std::int64_t spread = std::max<std::int64_t>(1, (last + pictures - 1) / pictures);
  const std::int64_t interval = settings.every_frames > 0 ? settings.every_frames : spread;
  std::vector<std::int64_t> out;
  for (std::int64_t frame = 0; frame < last; frame += interval) out.push_back(frame);
  out.push_back(last);
  return out;
}

std::vector<std::int64_t> in_contact(const std::vector<std::int64_t>& frames, const std::optional<FrameSpan>& contact) {
  if (!contact) return frames;
  const std::int64_t margin = 1 + (contact->last - contact->first) / kMarginParts;
  std::vector<std::int64_t> out;
  std::ranges::copy_if(frames, std::back_inserter(out), [&](std::int64_t frame) {
    return frame >= contact->first - margin && frame <= contact->last + margin;
  });
  return out.size() < 2 ? frames : out;
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

std::vector<std::int64_t> still_frames(const std::vector<std::int64_t>& frames, const RenderSettings& settings,
                                       const std::optional<FrameSpan>& contact) {
  if (settings.film == FilmFormat::none || settings.every_frames > 0) return frames;
  const std::vector<std::int64_t> among = in_contact(frames, contact);
  const auto ends = std::int64_t{among.front() != frames.front()} + std::int64_t{among.back() != frames.back()};
  std::vector<std::int64_t> out = evenly_among(among, static_cast<std::size_t>(kStills - ends));
  out.insert(out.end(), {frames.front(), frames.back()});
  sort_once(out);
  return out;
}

}  // namespace reamsim
