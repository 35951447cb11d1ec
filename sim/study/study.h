// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/record/output_folder.h"
#include "sim/scenario/yaml_tree.h"

namespace reamsim {

/// The value of a scenario key: as the study has it, and as `--set` takes it.
struct KeyValue {
  std::string shown;    ///< for tables
  std::string applied;  ///< YAML; input files are absolute. "": the base scenario's value stays
};

/// Keys that vary together, and their values, level by level: one key in a grid, several with `zip` and in a table.
struct Variation {
  std::vector<std::string> keys;
  std::vector<std::vector<KeyValue>> levels;  ///< levels[i][k]: of keys[k]
};

/// The table of a study, a row per patient.
struct CohortTable : Variation {
  std::vector<std::string> labels;             ///< column `label`, by row; empty: no such column
  std::vector<std::string> places;             ///< by row: file and line, for messages
  std::vector<std::vector<Mistake>> mistakes;  ///< by row: cells that name no input file
};

/// How a sampled key is distributed. `a`, `b`: normal: mean, standard deviation; lognormal: median, standard deviation
/// of the logarithm; uniform: ends; tilt_sd_deg: `a` is the standard deviation of two rotations, degrees, about axes
/// across a direction; shift_sd_mm: `a` is that of each component of a position, mm.
struct Distribution {
  enum class Kind { normal, lognormal, uniform, tilt_sd_deg, shift_sd_mm };

  Kind kind = Kind::normal;
  double a = 0;
  double b = 0;

  [[nodiscard]] int dimensions() const;
};

struct SampledKey {
  std::string key;
  Distribution distribution;
  SourceLocation where;
};

enum class SampleMethod { sobol, latin_hypercube, monte_carlo, saltelli };

struct SampleSettings {
  SampleMethod method = SampleMethod::sobol;
  SourceLocation method_where = {};  ///< where the study gives it
  int n = 0;
  std::uint64_t seed = 1;
  std::vector<SampledKey> of;
  std::vector<std::vector<double>> points;  ///< given points of the unit cube, in place of those of the method
};

/// A base scenario and what varies: every level of `vary` with every row of the table and every sample.
struct Study {
  std::string file;              ///< absolute
  std::string name;              ///< key `name`; without it the file's stem
  std::string base;              ///< absolute path of the scenario
  std::vector<std::string> set;  ///< "key=value", for every run
  std::vector<Variation> vary;
  std::optional<CohortTable> table;
  std::optional<SampleSettings> sample;
  KeptFiles keep{.forces = false, .grids = false, .pictures = false};
};

/// Throws InputError with all mistakes. Whether values of keys are valid is known only from each run's scenario.
Study read_study(const std::string& path);

/// assets/study.schema.json with the keys that a scenario has now.
std::string study_json_schema(const std::string& schema);

/// The value of a scenario key that a study has; `folder`: of the study file, the base of relative paths. Throws
/// InputError: unknown key, or a text that names no input file.
KeyValue value_of_node(const std::string& key, const YamlNode& node, const std::string& folder,
                       const SourceLocation& where);

/// Reads a CSV file (RFC 4180) whose columns are scenario keys, and one row per patient. An empty cell leaves the value
/// of the base scenario; a column `label` names the rows. A row with a cell that names no input file stays, with its
/// mistakes, so that the other rows run. `mistakes` gets those of the table: rows of another length, unknown keys.
CohortTable read_cohort_table(const std::string& path, const std::string& folder, MistakeList& mistakes);

}  // namespace reamsim
