// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>

namespace reamsim {

/// The stages in which a bone is loaded, and written by `reamsim import`. A CT has all but `distances`, a mesh `read`,
/// `distances`, `voxels` and `anatomy`, a VDB `read` and `anatomy`, a phantom `voxels` and `anatomy`.
enum class BoneStage { read, filter, segment, correct_density, distances, voxels, anatomy, write };

/// Called when a stage begins. May be empty.
using StageSink = std::function<void(BoneStage)>;

inline void begin_stage(const StageSink& sink, BoneStage stage) {
  if (sink) sink(stage);
}

}  // namespace reamsim
