// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "sim/base/diagnostics.h"
#include "sim/bone/bone.h"
#include "sim/scenario/scenario.h"
#include "sim/scene/load_bone.h"

namespace reamsim {

/// Keeps the bone that was loaded last, for runs that follow with the same bone.
class BoneCache {
 public:
  /// As load_bone(), with the same report. A bone is the same where its settings are, and where its files have kept
  /// their length and time of modification. Runs on a CT may have different glenoid frames.
  Bone load(const BoneSettings& settings, Diagnostics& report);
  /// How many different bones it has loaded so far.
  [[nodiscard]] int loaded() const { return loaded_; }

 private:
  std::string key_;
  Bone bone_;
  Diagnostics report_;
  int loaded_ = 0;
};

}  // namespace reamsim
