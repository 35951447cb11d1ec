// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/bone/voxmap/bone_stage.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// How far `reamsim import` is, by the usual times of its stages.
class ImportProgress {
 public:
  /// Takes the fraction of the expected time that has passed, and the stage that begins: "" at the end.
  using Sink = std::function<void(double, const std::string&)>;

  ImportProgress(const BoneSettings& settings, Sink sink);
  /// A stage that this bone does not have is passed over.
  void begin(BoneStage stage);
  void finish();

 private:
  struct Part {
    BoneStage stage;
    const char* name;
    double seconds;
  };

  std::vector<Part> parts_;
  double total_s_ = 0;
  Sink sink_;
};

}  // namespace reamsim
