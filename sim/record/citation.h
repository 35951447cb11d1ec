// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/record/references.h"

namespace reamsim {

/// The file of a results folder that says how to cite it.
inline constexpr const char* kCitationName = "CITATION.txt";

/// What to cite, by what it is cited for.
struct Citation {
  std::vector<Reference> program;
  std::vector<Reference> method;
  std::vector<Reference> data;
  std::vector<Reference> libraries;

  [[nodiscard]] std::vector<Reference> all() const;
};

/// Of the program itself.
Citation cite_program();
/// Of the results in DIR: of a run by its summary.json and scenario.yaml, of a study with uq.json its estimators as
/// well, of other results the program. Throws InputError where a file of a run is damaged.
Citation cite_results(const std::string& dir);

/// For people, with the entries of BibTeX below.
std::string text_of(const Citation& citation);
std::string bibtex_of(const Citation& citation);
/// A list of items in CSL-JSON, which reference managers read.
std::string csl_json_of(const Citation& citation);

/// Writes DIR/CITATION.txt. Throws RunError.
void write_citation(const std::string& dir);

}  // namespace reamsim
