// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <vector>

#include "sim/scenario/scenario.h"

namespace reamsim {

/// Frames of a run, both ends included.
struct FrameSpan {
  std::int64_t first = 0;
  std::int64_t last = 0;

  friend bool operator==(const FrameSpan&, const FrameSpan&) = default;
};

/// Ascending, of the passes that touch the bone; none: not known, or no contact.
using FrameSpans = std::vector<FrameSpan>;

/// Frames of which a snapshot is kept for pictures, ascending: 0, `last` and, between, every n-th. Without a number in
/// the settings these are evenly spaced: for a film or without contact along the run, else in contact.
std::vector<std::int64_t> picture_frames(const RenderSettings& settings, std::int64_t last, const FrameSpans& contact);

/// Of `frames` (ascending), those in contact with a margin of 5 %; all of them if there are not two of these.
std::vector<std::int64_t> in_contact(const std::vector<std::int64_t>& frames, const FrameSpans& contact);

/// At most `most` (2 or more) of `frames` (ascending), evenly distributed, with the first and the last.
std::vector<std::int64_t> evenly_among(const std::vector<std::int64_t>& frames, std::size_t most);

/// Of the frames with a snapshot, those of still pictures: all, or where a film has set their number the first, the
/// last, and others in contact.
std::vector<std::int64_t> still_frames(const std::vector<std::int64_t>& frames, const RenderSettings& settings,
                                       const FrameSpans& contact);

}  // namespace reamsim
