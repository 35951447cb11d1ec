// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>

namespace reamsim {

struct Bone;
struct BoneSettings;
struct FilledVoxmap;
struct Report;
struct Segmentation;

/// The stages in which a bone is loaded, and written by `reamsim import`. A CT has all but `distances`, a mesh `read`,
/// `distances`, `voxels` and `anatomy`, a VDB `read` and `anatomy`, a phantom `voxels` and `anatomy`.
enum class BoneStage { read, filter, segment, correct_density, distances, voxels, anatomy, write };

/// Called when a stage begins. May be empty.
using StageSink = std::function<void(BoneStage)>;

inline void begin_stage(const StageSink& sink, BoneStage stage) {
  if (sink) sink(stage);
}

// As the functions of sim/bone/bone.h and sim/bone/ct/ct_import.h, with stages.
Bone load_bone(const BoneSettings& settings, Report& report, const StageSink& stages);
FilledVoxmap voxmap_from_ct(const BoneSettings& settings, Report& report, Segmentation* segmentation,
                            const StageSink& stages);
FilledVoxmap voxmap_from_mesh(const BoneSettings& settings, Report& report, const StageSink& stages);

}  // namespace reamsim
