// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <string>
#include <vector>

namespace reamsim {

/// Messages of a stage for the user. The caller prints them, so that no engine prints.
struct Diagnostics {
  std::vector<std::string> notes;
  std::vector<std::string> warnings;
  std::vector<std::string> listings;

  void note(std::string text) { notes.push_back(std::move(text)); }
  void warn(std::string text) { warnings.push_back(std::move(text)); }
  /// What a warning refers to and the results must not hold, because it may identify a patient.
  void list(std::string text) { listings.push_back(std::move(text)); }
};

}  // namespace reamsim
