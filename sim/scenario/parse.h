// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/error.h"
#include "sim/scenario/paths.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// Reads and validates a scenario file. `overrides` are "key.path=value" strings (`--set`), applied before validation.
/// ${VAR} in paths is expanded from the environment; relative paths are relative to the scenario's folder.
/// Throws InputError naming file, line, column, key, what was found and what would be right.
Scenario parse_scenario(const std::string& path, const std::vector<std::string>& overrides);

/// The overrides that make a quick look of a scenario: its name with "-draft", voxels twice as large (a VDB
/// keeps its own), pictures of its first camera at the start and the end only, no report, plots, meshes or reamed.vti.
std::vector<std::string> draft_overrides(const Scenario& scenario);

/// The settings of a run's scenario.yaml that pictures, plots and reports need.
struct ResultSettings {
  RenderSettings render;
  CuttingSettings cutting;
  OutputSettings output;
  ToolSpin tool_spin = ToolSpin::envelope;
};

/// Reads them, with overrides. Does not require the input files.
ResultSettings parse_result_settings(const std::string& path, const std::vector<std::string>& overrides = {});

/// What forces depend on beside the geometry, in a run's scenario.yaml.
struct LawSettings {
  CuttingSettings cutting;
  DensitySettings density;
  std::string bone_source;   ///< as in the file
  std::string yaml;          ///< the file's text with these settings
  bool force_basis = false;  ///< the run has one
};

/// Reads them, with overrides of keys of `cutting` and `bone.density`; the other keys are those of the run. A preset or
/// a table in the overrides replaces the power law of the run. Does not require the input files. Throws InputError.
LawSettings parse_law_settings(const std::string& path, const std::vector<std::string>& overrides = {});

/// A bone section of a source ("ct" or "mesh"), its path and overrides ("bone.voxel_mm=0.5"), for `reamsim import`.
BoneSettings parse_bone_settings(const std::string& source, const std::string& path,
                                 const std::vector<std::string>& overrides);

/// The resolved scenario as YAML text: every default filled in. Parsing it again gives the same scenario.
std::string to_yaml(const Scenario& scenario,
                    const std::function<std::string(const std::string& path)>& path_text = recorded_path);

/// Every file or DICOM folder that the scenario names as an input: (its key, absolute path).
std::vector<std::pair<std::string, std::string>> input_files(const Scenario& scenario);

// What follows from the keys of a scenario: values of presets, and the passes of its motion.

/// Sets the keys that `cutting.preset` defines, except those that the scenario gives. Sources: docs/physics.md, 4.
void apply_preset(const KeyLocations& locations, CuttingSettings& cutting);

/// Keys of the section `cutting` that differ from its preset; none without a preset.
std::vector<std::string_view> changed_from_preset(const CuttingSettings& cutting);

/// Replaces the defaults of a glenoid phantom by those of its Walch type. Sources: docs/glenoid.md.
void apply_walch_defaults(PhantomSettings& phantom);

/// A tool and its motion. A scenario without `motion.passes` has one pass.
struct PassSpec {
  ToolSettings tool;
  MotionSettings motion;   ///< without passes
  std::string tool_key;    ///< of the section that `tool` is from
  std::string motion_key;  ///< of the section of the motion: motion, or motion.passes.N
};

std::vector<PassSpec> passes_of(const Scenario& scenario);

/// A mistake of this pass with the keys of the whole scenario: motion.plunge.axis is motion.passes.1.plunge.axis.
InputError in_pass(const PassSpec& pass, const InputError& error);

}  // namespace reamsim
