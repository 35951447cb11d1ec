// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "sim/base/error.h"
#include "sim/scenario/key_tree.h"
#include "sim/scenario/scenario.h"
#include "sim/scenario/yaml_tree.h"

namespace reamsim {

// The steps of parse_scenario() before and after read_keys().

/// Applies one `--set key.path=value` to a document and returns the changed one. Creates missing sections;
/// "motion.keyframes.0.time_s" is an element of a list; the value null removes the key. The value is read as YAML
/// ("[0, 0, 5]" is a list), or as plain text where it is not YAML or is a section.
/// Throws InputError ("--set key=value: ..."): no "=", no key, an index beyond the list.
YamlNodePtr apply_override(const YamlNodePtr& document, const std::string& assignment);

/// Reads the keys that `describe` visits into `scenario`, with their places and the files of markups; lists unknown
/// keys of the document. Checks each key by itself; check_rules() checks keys against each other. `folder`: base of
/// relative paths. `file`: name in messages.
///
/// Lists each mistake and continues with the default value. Does not report consequences of a mistake: keys that depend
/// on a wrong or missing choice, missing keys beside an unknown key, the contents of a section that is not one.
void read_keys(const YamlNodePtr& document, const std::string& file, const std::string& folder,
               void (*describe)(KeyVisitor&, Scenario&), Scenario& scenario, MistakeList& mistakes);

/// Lists a mistake for each broken rule of more than one key, at the key to change, unless these have mistakes already.
void check_rules(const Scenario& scenario, const KeyLocations& locations, MistakeList& mistakes);

// Rules of one section each. They throw InputError at the key to change.

/// Names that files can have, each once; a direction of view, and an up across it.
void check_cameras(const Scenario& scenario, const KeyLocations& locations);
/// A footprint that its back covers, directions that span its frame, pegs with a length.
void check_implant(const Scenario& scenario, const KeyLocations& locations);
/// The size of a joint face, not on a line, in order around it.
void check_rim(const Scenario& scenario, const KeyLocations& locations);
/// What the balance of forces in every frame needs.
void check_push(const Scenario& scenario, const KeyLocations& locations);
void check_compliance(const Scenario& scenario, const KeyLocations& locations);
/// As many columns as there are components, rotations that are some, and one frame of the poses.
void check_csv(const Scenario& scenario, const KeyLocations& locations);

/// Points of markups are in the frame of the bone: lists a mistake for each key that has another frame.
void check_markups_frames(const Scenario& scenario, const KeyLocations& locations, MistakeList& mistakes);

/// Whether two directions are so close that a direction across one of them is noise.
bool are_parallel(const Vec3& a, const Vec3& b);

/// Throws InputError unless a frame of motion.push at its fastest feed is one substep (engine.max_step_voxels), so that
/// the balance of the frame is that of its cut. `scenario` has the edge length of the voxels, which a VDB tells.
void check_push_step(const Scenario& scenario, const KeyLocations& locations);

/// The rules of a key that has to be given, within a range.
inline KeyRules required(const Range& range) {
  return {.required = true, .range = range};
}

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
