#pragma once

#include "sim/scenario/key_visitor.h"

namespace reamsim {

/// Of positions in mm; those further out are mistakes of unit or frame.
constexpr Range kPosition = between(-10000, 10000);
/// Of a direction's components; it need not have length 1.
constexpr Range kComponent = between(-1000, 1000);

// The parts of describe_scenario(), one per top-level section.

void describe_bone(KeyVisitor& v, BoneSettings& bone);
void describe_tool(KeyVisitor& v, ToolSettings& tool);
void describe_motion(KeyVisitor& v, MotionSettings& motion);
void describe_engine(KeyVisitor& v, EngineSettings& engine);
void describe_cutting(KeyVisitor& v, CuttingSettings& cutting);
void describe_metrics(KeyVisitor& v, MetricSettings& metrics);
void describe_render(KeyVisitor& v, RenderSettings& render);
void describe_output(KeyVisitor& v, OutputSettings& output);

}  // namespace reamsim
