// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/run_messages.h"

#include <fmt/core.h>

#include <algorithm>

namespace reamsim {

void RunMessages::add(int number, const std::vector<std::string>& messages) {
  runs_ += messages.empty() ? 0 : 1;
  for (const std::string& message : messages) {
    const auto found = std::ranges::find(texts_, message, &Text::message);
    if (found != texts_.end()) {
      ++found->runs;
    } else if (texts_.size() < kMost) {
      texts_.push_back({number, 1, message});
    }
  }
}

std::vector<std::string> RunMessages::lines(std::size_t most) const {
  std::vector<std::string> out;
  for (std::size_t i = 0; i < std::min(most, texts_.size()); ++i) {
    const Text& text = texts_[i];
    const std::string more = text.runs > 1 ? fmt::format(" and {} more", text.runs - 1) : "";
    out.push_back(fmt::format("run {}{}: {}", text.number, more, text.message));
  }
  return out;
}

}  // namespace reamsim
