// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

namespace reamsim {

/// A work to cite.
struct Reference {
  std::string key;                   ///< "faieghi2020"
  std::string type;                  ///< of CSL: software | article-journal | dataset | webpage
  std::vector<std::string> authors;  ///< "Faieghi, M."; a group as it calls itself, without a comma
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
/// An entry of BibTeX.
std::string bibtex_of(const Reference& reference);

}  // namespace reamsim
