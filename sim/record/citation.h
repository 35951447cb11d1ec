// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

namespace reamsim {

struct Reference {
  std::string key;                       ///< "faieghi2020"
  std::string type = "article-journal";  ///< of CSL: software | article-journal | dataset | webpage
  std::vector<std::string> authors{};    ///< "Faieghi, M."; a group as it calls itself, without a comma
  std::string title;
  int year = 0;  ///< 0: unknown
  std::string journal{};
  std::string volume{};
  std::string pages{};  ///< or the number of the article
  std::string version{};
  std::string doi{};
  std::string url{};
  std::string note{};  ///< what it stands for, licence, checksum
};

/// A published work by its key, with its note. Throws std::out_of_range: a key that no table has.
Reference known_reference(const std::string& key, const std::string& note = "");
/// A public data set by the SHA-256 of its file; its key is "" if reamsim does not know the data set.
Reference known_data(const std::string& sha256);

/// One line: authors, year, title, journal, DOI, note.
std::string text_of(const Reference& reference);
std::string bibtex_of(const Reference& reference);
inline constexpr const char* kCitationName = "CITATION.txt";

/// What to cite, by what it is cited for.
struct Citation {
  std::vector<Reference> program;
  std::vector<Reference> method;
  std::vector<Reference> data;
  std::vector<Reference> libraries;

  [[nodiscard]] std::vector<Reference> all() const;
};

Citation cite_program();
/// Of runs, each work once. Throws InputError where a summary.json, or a scenario.yaml that matters, is damaged.
Citation cite_runs(const std::vector<std::string>& dirs);
/// Of a run, a study (its runs that are done and undamaged, and the estimators of uq.json), a benchmark or a
/// verification. Throws InputError where a file of a single run is damaged, or DIR is a comparison.
Citation cite_results(const std::string& dir);

/// For people, with the entries of BibTeX below.
std::string text_of(const Citation& citation);
std::string bibtex_of(const Citation& citation);
/// A list of items in CSL-JSON, which reference managers read.
std::string csl_json_of(const Citation& citation);

/// Writes DIR/CITATION.txt. Throws RunError.
void write_citation(const std::string& dir, const Citation& citation);

}  // namespace reamsim
