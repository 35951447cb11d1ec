#pragma once

#include <cstdint>
#include <vector>

#include "sim/scenario/scenario.h"

namespace reamsim {

/// Frames of which a snapshot is kept for pictures: 0, every n-th and `last`. Ascending.
std::vector<std::int64_t> picture_frames(const RenderSettings& settings, std::int64_t last);

/// At most `most` (2 or more) of `frames` (ascending), evenly distributed, with the first and the last.
std::vector<std::int64_t> evenly_among(const std::vector<std::int64_t>& frames, std::size_t most);

/// Of the frames with a snapshot, those that are rendered as still pictures: all of them, or some where a film has set
/// their number.
std::vector<std::int64_t> still_frames(const std::vector<std::int64_t>& frames, const RenderSettings& settings);

}  // namespace reamsim
