// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/bone/voxmap/bone_stage.h"

namespace reamsim {

struct Bone;
struct BoneSettings;
struct FilledVoxmap;
struct Report;

// As the functions of sim/bone/bone.h, with stages.
Bone load_bone(const BoneSettings& settings, Report& report, const StageSink& stages);
FilledVoxmap voxmap_from_mesh(const BoneSettings& settings, Report& report, const StageSink& stages);

}  // namespace reamsim
