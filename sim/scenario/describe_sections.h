// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/scenario/key_visitor.h"

namespace reamsim {

/// Range of densities that are not 0, g/cm³, from the least that a voxel stores.
constexpr Range kDensity = between(0.008, 2);
/// Range of the length in mm of a unit of a file, from nanometres to kilometres.
constexpr Range kFileUnit = between(1e-6, 1e6);

/// Range of radiodensities.
constexpr Range kHu = between(-2000, 10000);

// The parts of describe_scenario(), one per top-level section; describe_density() belongs to describe_bone().

void describe_bone(KeyVisitor& v, BoneSettings& bone);
void describe_density(KeyVisitor& v, DensitySettings& density);
void describe_tool(KeyVisitor& v, ToolSettings& tool);
void describe_clearance(KeyVisitor& v, ClearanceSettings& clearance);
void describe_motion(KeyVisitor& v, MotionSettings& motion);
void describe_engine(KeyVisitor& v, EngineSettings& engine);
void describe_cutting(KeyVisitor& v, CuttingSettings& cutting);
void describe_render(KeyVisitor& v, RenderSettings& render);
void describe_output(KeyVisitor& v, OutputSettings& output);

}  // namespace reamsim
