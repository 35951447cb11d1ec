#pragma once

#include <cstdint>
#include <vector>

#include "sim/scenario/scenario.h"

namespace reamsim {

/// Frames whose state is kept for pictures: 0, every n-th and the last, which is `last`. Ascending.
std::vector<std::int64_t> picture_frames(const RenderSettings& settings, std::int64_t last);

/// At most `most` (2 or more) of these frames, evenly among them, with the first and the last. Ascending, as they are.
std::vector<std::int64_t> evenly_among(const std::vector<std::int64_t>& frames, std::size_t most);

/// The frames that have pictures of their own, of those that have a snapshot: all, but for a film that says itself how
/// many it has no more than a run without one.
std::vector<std::int64_t> still_frames(const std::vector<std::int64_t>& frames, const RenderSettings& settings);

}  // namespace reamsim
