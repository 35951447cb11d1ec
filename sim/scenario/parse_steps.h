// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/scenario/key_tree.h"
#include "sim/scenario/scenario.h"
#include "sim/scenario/yaml_tree.h"

namespace reamsim {

// The steps of parse_scenario() before and after the reader, in their order. Each has a file of its own.

/// The file's document, with overrides, in the present version of the format. `notes`: see migrate(). Throws
/// InputError.
YamlNodePtr read_document(const std::string& path, const std::vector<std::string>& overrides,
                          std::vector<std::string>& notes);

/// Applies one `--set key.path=value` to a document and returns the changed one. Creates missing sections;
/// "motion.keyframes.0.time_s" is an element of a list; the value null removes the key. The value is read as YAML
/// ("[0, 0, 5]" is a list), or as plain text where it is not YAML or is a section.
/// Throws InputError ("--set key=value: ..."): no "=", no key, an index beyond the list.
YamlNodePtr apply_override(const YamlNodePtr& document, const std::string& assignment);

/// Brings a scenario with keys of format version 1 to version 2: renames keys and drops those that have no effect any
/// more. Adds a note for each ("FILE:LINE:COLUMN: KEY: ..."). Throws InputError where a key is given under both names.
YamlNodePtr migrate(const YamlNodePtr& document, const std::string& file, std::vector<std::string>& notes);

/// Lists every key of the document that key_tree() does not have, with the key that was probably meant. Leaves sections
/// that do not hold keys to the reader.
void reject_unknown_keys(const YamlNode& document, const std::string& file, MistakeList& mistakes);

/// The rules that concern more than one key. Lists a mistake for each broken rule, at the key to change; skips rules of
/// keys that have a mistake already.
void check_rules(const Scenario& scenario, const KeyLocations& locations, MistakeList& mistakes);

/// The rules of user cameras: names that files can have, each once; a direction of view, and an up across it.
/// Throws InputError.
void check_cameras(const RenderSettings& render, const KeyLocations& locations);

/// The rules of metrics.implant: a footprint that its back covers, directions that span its frame, pegs with a length.
/// Throws InputError.
void check_implant(const ImplantSettings& implant, const KeyLocations& locations);

/// The rules of bone.glenoid.rim_mm: the size of a joint face, not on a line, in order around it. Throws InputError.
void check_rim(const std::vector<Vec3>& rim_mm, const KeyLocations& locations);

/// Points of markups are in the frame of the bone: lists a mistake for each key that has another frame.
void check_markups_frames(const Scenario& scenario, const KeyLocations& locations, MistakeList& mistakes);

/// The rules of motion.push: what the balance of forces in every frame needs. Throws InputError.
void check_push(const Scenario& scenario, const KeyLocations& locations);

/// The rules of motion.csv: as many columns as there are components, rotations that are some, and one frame of the
/// poses. Throws InputError.
void check_csv(const Scenario& scenario, const KeyLocations& locations);

/// The rules of motion.compliance: likewise. Throws InputError.
void check_compliance(const Scenario& scenario, const KeyLocations& locations);

/// Throws InputError unless a frame of motion.push at its fastest feed is one substep (engine.max_step_voxels), so that
/// the balance of the frame is that of its cut. `scenario` has the edge length of the voxels, which a VDB tells.
void check_push_step(const Scenario& scenario, const KeyLocations& locations);

}  // namespace reamsim
