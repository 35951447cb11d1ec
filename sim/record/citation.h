// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

namespace reamsim {

inline constexpr const char* kCitationName = "CITATION.txt";

/// What to cite: program, method, data and libraries.
struct Citation {
  std::string text;      ///< for people
  std::string bibtex;    ///< an entry for each work
  std::string csl_json;  ///< a list of items, which reference managers read
};

Citation cite_program();
/// Of runs, each work once. Throws InputError where a summary.json, or a scenario.yaml that matters, is damaged.
Citation cite_runs(const std::vector<std::string>& dirs);
/// Of a run, a study (its runs that are done and undamaged, and the estimators of uq.json), a benchmark or a
/// verification. Throws InputError where a file of a single run is damaged, or DIR is a comparison.
Citation cite_results(const std::string& dir);

/// Writes DIR/CITATION.txt. Throws RunError.
void write_citation(const std::string& dir, const Citation& citation);

}  // namespace reamsim
