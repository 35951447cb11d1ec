// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <string>

#include "sim/study/collect.h"

namespace reamsim {

inline constexpr std::size_t kMostBytesOfStudyPage = 14'500'000;

/// The page of a study: HTML without network, at most `most_bytes`, which sorts, filters and plots its runs and opens
/// their reports. A study that would be larger has a part of its runs, drawn at random; the page says so.
std::string study_page(const std::string& study, const RunTable& table, std::size_t most_bytes = kMostBytesOfStudyPage);

}  // namespace reamsim
