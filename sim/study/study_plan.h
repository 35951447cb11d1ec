// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/geometry.h"
#include "sim/record/output_folder.h"
#include "sim/scenario/scenario.h"
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

/// The value of a scenario key that a study has; `folder`: of the study file, the base of relative paths. Throws
/// InputError: unknown key, or a text that names no input file.
KeyValue value_of_node(const std::string& key, const YamlNode& node, const std::string& folder,
                       const SourceLocation& where);

/// Reads a CSV file (RFC 4180) whose columns are scenario keys, and one row per patient. An empty cell leaves the value
/// of the base scenario; a column `label` names the rows. A row with a cell that names no input file stays, with its
/// mistakes, so that the other rows run. `mistakes` gets those of the table: rows of another length, unknown keys.
CohortTable read_cohort_table(const std::string& path, const std::string& folder, MistakeList& mistakes);

/// Points of the open unit cube: points[i][d], `n` of them, or with saltelli n·(dimensions + 2).
///
/// sobol: the sequence of Sobol with the direction numbers of Joe and Kuo (2008), randomized by a digital shift;
/// latin_hypercube: one point in each of n equal intervals of every dimension (McKay et al. 1979); monte_carlo:
/// independent points; saltelli: the matrices A, B and A with one column of B, for every dimension (Saltelli et al.
/// 2010), from a sobol sequence of twice the dimensions; rows i·(dimensions + 2) … of the result are A, B, AB₁, AB₂, …
/// of point i.
///
/// The same arguments give the same points on every machine. With sobol, monte_carlo and saltelli, a larger n only adds
/// points. Throws InputError for more dimensions than the sequence has.
std::vector<std::vector<double>> unit_points(SampleMethod method, int n, int dimensions, std::uint64_t seed);

/// The inverse of the cumulative distribution (normal, lognormal, uniform) at u in (0, 1).
double sample_number(const Distribution& distribution, double u);

double normal_quantile(double u);

/// `direction`, of unit length, rotated about the axis (a·e₁ + b·e₂) by its length in degrees; e₁ and e₂ are unit
/// vectors across it: e₁ along direction × x, or direction × y where the direction lies no nearer to y than to x.
Vec3 tilted(const Vec3& direction, double a_deg, double b_deg);

struct PlannedRun {
  int number = 0;                      ///< from 1, in the order of the plan
  std::vector<std::string> cells;      ///< by column of the plan
  std::vector<std::string> overrides;  ///< of the base scenario, "key=value"
  std::string place;                   ///< of its row in the table, for messages; "": none
  std::vector<Mistake> mistakes;       ///< of the cells of that row
};

/// All runs of a study, and their parameters as a table.
struct StudyPlan {
  std::vector<std::string> columns;  ///< `label` where the table has it; keys; parts of tilts and shifts
  std::vector<PlannedRun> runs;
};

/// Columns of the parts of a tilt or shift: KEY.tilt_1_deg, KEY.tilt_2_deg or KEY.shift_x_mm, _y, _z; none of a number.
std::vector<std::string> part_columns(const SampledKey& sampled);

/// Combines every level of `vary`, every row of the table and every sample, the first variation slowest, samples
/// fastest, so that runs with the same bone tend to be neighbours. A tilt or shift changes the vector that the run has
/// otherwise, and adds part_columns(). `overrides`: for every run, after those of the study. Throws InputError: too
/// many runs, or a vector to change that neither the base scenario nor the study gives.
StudyPlan make_plan(const Study& study, const std::vector<std::string>& overrides = {});

struct IdentifiedRun {
  std::string id;       ///< run_id(); "" where the scenario is wrong
  std::string mistake;  ///< then why: all mistakes of its row and its scenario, on one line
};

/// Parses the scenario of every run. `done`: called with the number of finished runs.
std::vector<IdentifiedRun> identify_runs(const Study& study, const StudyPlan& plan,
                                         const std::function<void(std::size_t)>& done = {});

/// The runs with the folder of this one, itself among them: a table may have a patient twice.
std::vector<std::size_t> rows_of_run(const std::vector<IdentifiedRun>& runs, std::size_t run);

/// "runs 3 and 7 are the same run", a line for each such group, of at most three.
std::vector<std::string> same_runs(const std::vector<IdentifiedRun>& runs);

/// The scenario of a run. Throws InputError.
Scenario scenario_of(const Study& study, const PlannedRun& run);

}  // namespace reamsim
