// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/picture_frames.h"

#include <algorithm>
#include <iterator>
#include <set>

namespace reamsim {
namespace {

/// Frames if the settings give no number, the first and the last included.
constexpr std::int64_t kStills = 11;
constexpr std::int64_t kFilmPictures = 150;
/// Margin around the contact, parts of it: 1/20.
constexpr std::int64_t kMarginParts = 20;

/// The i-th of the frames of all spans.
std::int64_t frame_of(const FrameSpans& spans, std::int64_t i) {
  for (const FrameSpan& span : spans) {
    const std::int64_t frames = span.last - span.first + 1;
    if (i < frames) return span.first + i;
    i -= frames;
  }
  return spans.back().last;
}

/// 0, `last`, and between them as many in contact as make the number of stills.
std::vector<std::int64_t> spread_over(FrameSpans contact, std::int64_t last) {
  std::int64_t frames = 0;
  for (FrameSpan& span : contact) {
    span.first = std::clamp<std::int64_t>(span.first, 0, last);
    span.last = std::clamp(span.last, span.first, last);
    frames += span.last - span.first + 1;
  }
  const int ends = (contact.front().first > 0 ? 1 : 0) + (contact.back().last < last ? 1 : 0);
  const std::int64_t steps = kStills - ends - 1;
  std::set<std::int64_t> out{0, last};
  for (std::int64_t i = 0; i <= steps; ++i) out.insert(frame_of(contact, (2 * i * (frames - 1) + steps) / (2 * steps)));
  return {out.begin(), out.end()};
}

bool is_near(const FrameSpan& contact, std::int64_t frame) {
  const std::int64_t margin = 1 + (contact.last - contact.first) / kMarginParts;
  return frame >= contact.first - margin && frame <= contact.last + margin;
}

}  // namespace

std::vector<std::int64_t> picture_frames(const RenderSettings& settings, std::int64_t last, const FrameSpans& contact) {
  const bool film = settings.enabled && settings.film != FilmFormat::none;
  if (settings.every_frames == 0 && !film && !contact.empty()) return spread_over(contact, last);
  const std::int64_t pictures = film ? kFilmPictures : kStills - 1;
  const std::int64_t spread = std::max<std::int64_t>(1, (last + pictures - 1) / pictures);
  const std::int64_t interval = settings.every_frames > 0 ? settings.every_frames : spread;
  std::vector<std::int64_t> out;
  for (std::int64_t frame = 0; frame < last; frame += interval) out.push_back(frame);
  out.push_back(last);
  return out;
}

std::vector<std::int64_t> in_contact(const std::vector<std::int64_t>& frames, const FrameSpans& contact) {
  if (contact.empty()) return frames;
  std::vector<std::int64_t> out;
  std::ranges::copy_if(frames, std::back_inserter(out), [&](std::int64_t frame) {
    return std::ranges::any_of(contact, [frame](const FrameSpan& span) { return is_near(span, frame); });
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
                                       const FrameSpans& contact) {
  if (settings.film == FilmFormat::none || settings.every_frames > 0) return frames;
  const std::vector<std::int64_t> among = in_contact(frames, contact);
  const auto ends = std::int64_t{among.front() != frames.front()} + std::int64_t{among.back() != frames.back()};
  const std::vector<std::int64_t> spread = evenly_among(among, static_cast<std::size_t>(kStills - ends));
  std::set<std::int64_t> out{frames.front(), frames.back()};
  out.insert(spread.begin(), spread.end());
  return {out.begin(), out.end()};
}

}  // namespace reamsim
