// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/citation.h"

#include <algorithm>
#include <array>
#include <stdexcept>

namespace reamsim {

namespace {

// Sources: docs/physics.md, the pages that it lists, and docs/engines.md, which say what each is used for.
const std::vector<Reference>& published() {
  static const std::vector<Reference> all{
      {.key = "faieghi2020",
       .authors = {"Faieghi, M.", "Tutunea-Fatan, O. R.", "Eagleson, R."},
       .title = "Parallelized collision detection with applications in virtual bone machining",
       .year = 2020,
       .journal = "Computer Methods and Programs in Biomedicine",
       .volume = "188",
       .pages = "105263",
       .doi = "10.1016/j.cmpb.2019.105263"},
      {.key = "scardovelli2000",
       .authors = {"Scardovelli, R.", "Zaleski, S."},
       .title = "Analytical relations connecting linear interfaces and volume fractions in rectangular grids",
       .year = 2000,
       .journal = "Journal of Computational Physics",
       .volume = "164",
       .pages = "228-237",
       .doi = "10.1006/jcph.2000.6567"},
      {.key = "aslam2004",
       .authors = {"Aslam, T. D."},
       .title = "A partial differential equation approach to multidimensional extrapolation",
       .year = 2004,
       .journal = "Journal of Computational Physics",
       .volume = "193",
       .pages = "349-355",
       .doi = "10.1016/j.jcp.2003.08.001"},
      {.key = "pmc5234499",
       .type = "webpage",
       .title = "PMC5234499, Table 1",
       .url = "https://www.ncbi.nlm.nih.gov/pmc/articles/PMC5234499/"},
      {.key = "broyden1965",
       .authors = {"Broyden, C. G."},
       .title = "A class of methods for solving nonlinear simultaneous equations",
       .year = 1965,
       .journal = "Mathematics of Computation",
       .volume = "19",
       .pages = "577-593",
       .doi = "10.1090/S0025-5718-1965-0198670-6"},
      {.key = "sobol2001",
       .authors = {"Sobol, I. M."},
       .title = "Global sensitivity indices for nonlinear mathematical models and their Monte Carlo estimates",
       .year = 2001,
       .journal = "Mathematics and Computers in Simulation",
       .volume = "55",
       .pages = "271-280",
       .doi = "10.1016/S0378-4754(00)00270-6"},
      {.key = "saltelli2010",
       .authors = {"Saltelli, A.", "Annoni, P.", "Azzini, I.", "Campolongo, F.", "Ratto, M.", "Tarantola, S."},
       .title =
           "Variance based sensitivity analysis of model output. Design and estimator for the total sensitivity index",
       .year = 2010,
       .journal = "Computer Physics Communications",
       .volume = "181",
       .pages = "259-270",
       .doi = "10.1016/j.cpc.2009.09.018"},
      {.key = "jansen1999",
       .authors = {"Jansen, M. J. W."},
       .title = "Analysis of variance designs for model output",
       .year = 1999,
       .journal = "Computer Physics Communications",
       .volume = "117",
       .pages = "35-43",
       .doi = "10.1016/S0010-4655(98)00154-4"},
      {.key = "museth2013",
       .authors = {"Museth, K."},
       .title = "VDB: high-resolution sparse volumes with dynamic topology",
       .year = 2013,
       .journal = "ACM Transactions on Graphics",
       .volume = "32",
       .pages = "27",
       .doi = "10.1145/2487228.2487235"},
      {.key = "mccormick2014",
       .authors = {"McCormick, M.", "Liu, X.", "Jomier, J.", "Marion, C.", "Ibanez, L."},
       .title = "ITK: enabling reproducible research and open science",
       .year = 2014,
       .journal = "Frontiers in Neuroinformatics",
       .volume = "8",
       .pages = "13",
       .doi = "10.3389/fninf.2014.00013"},
      {.key = "jaaskelainen2015",
       .authors = {"J\u00e4\u00e4skel\u00e4inen, P.", "S\u00e1nchez de La Lama, C.", "Schnetter, E.", "Raiskila, K.",
                   "Takala, J.", "Berg, H."},
       .title = "pocl: a performance-portable OpenCL implementation",
       .year = 2015,
       .journal = "International Journal of Parallel Programming",
       .volume = "43",
       .pages = "752-785",
       .doi = "10.1007/s10766-014-0320-y"},
      {.key = "eigen",
       .type = "software",
       .authors = {"Guennebaud, G.", "Jacob, B.", "others"},
       .title = "Eigen v3",
       .year = 2010,
       .url = "https://eigen.tuxfamily.org"},
  };
  return all;
}

struct KnownFile {
  const char* sha256;
  Reference reference;
};

// The files that docs/command-line.md names under "Data".
const std::vector<KnownFile>& public_files() {
  static const std::vector<KnownFile> all{
      {"67e5af7b99fbdeb342fb9b01b5c3e4e0f07da4fa79614dbdc76838baed767c96",
       {.key = "armato2015",
        .type = "dataset",
        .authors = {"Armato III, S. G.", "McLennan, G.", "Bidaut, L.", "others"},
        .title = "Data from LIDC-IDRI",
        .year = 2015,
        .journal = "The Cancer Imaging Archive",
        .doi = "10.7937/K9/TCIA.2015.LO9QL9SX",
        .note = "series of LIDC-IDRI-0314, cropped; CC BY 3.0"}},
      {"715a85596e44c6a7566f74d6228b0d5a16760b9c801f1f074decc3aa769fdfb5",
       {.key = "handot",
        .type = "dataset",
        .authors = {"HandOT"},
        .title = "Upper Limb Bones (Left)",
        .url = "https://github.com/devonjones/openforge-components",
        .note = "surface of the scapula, commit 564605bc; CC BY-SA 3.0"}},
  };
  return all;
}

std::string joined(const std::vector<std::string>& authors, const std::string& separator) {
  std::string out;
  for (const std::string& author : authors) out += (out.empty() ? "" : separator) + author;
  return out;
}

/// A value of BibTeX between braces. Braces within it must be in pairs, so those of a file name are left out.
std::string braced(const std::string& text) {
  std::string out = "{";
  for (const char c : text) {
    if (c == '{' || c == '}' || c == '\\') continue;
    if (std::string_view("&%$#_").find(c) != std::string_view::npos) out += '\\';
    out += c;
  }
  return out + "}";
}

}  // namespace

Reference known_reference(const std::string& key, const std::string& note) {
  const auto found = std::ranges::find(published(), key, &Reference::key);
  if (found == published().end()) throw std::out_of_range("no reference " + key);
  Reference out = *found;
  out.note = note;
  return out;
}

Reference known_data(const std::string& sha256) {
  const auto found = std::ranges::find(public_files(), sha256, &KnownFile::sha256);
  return found == public_files().end() ? Reference{} : found->reference;
}

std::string text_of(const Reference& reference) {
  std::vector<std::string> authors = reference.authors;
  const bool more = !authors.empty() && authors.back() == "others";  // as BibTeX calls them
  if (more) authors.pop_back();
  std::string out = joined(authors, ", ") + (more ? " et al." : "");
  if (reference.year > 0) out += " (" + std::to_string(reference.year) + ")";
  out += (out.empty() ? "" : ": ") + reference.title;
  if (!reference.version.empty()) out += ", version " + reference.version;
  if (!reference.journal.empty()) out += ". " + reference.journal;
  if (!reference.volume.empty()) out += " " + reference.volume;
  if (!reference.pages.empty()) out += ", " + reference.pages;
  if (!reference.doi.empty()) out += ". doi:" + reference.doi;
  if (!reference.url.empty()) out += ". " + reference.url;
  if (!reference.note.empty()) out += " [" + reference.note + "]";
  return out;
}

std::string bibtex_of(const Reference& reference) {
  std::string out = (reference.type == "article-journal" ? "@article{" : "@misc{") + reference.key;
  const auto field = [&](const char* name, const std::string& value, bool as_it_is = false) {
    if (!value.empty()) out += std::string(",\n  ") + name + " = " + (as_it_is ? "{" + value + "}" : braced(value));
  };
  std::vector<std::string> authors = reference.authors;
  for (std::string& author : authors) {
    if (author.find(',') == std::string::npos && author != "others") author = "{" + author + "}";  // a group
  }
  field("author", joined(authors, " and "), true);
  field("title", reference.title);
  if (reference.year > 0) field("year", std::to_string(reference.year));
  field(reference.type == "article-journal" ? "journal" : "publisher", reference.journal);
  field("volume", reference.volume);
  field("pages", reference.pages);
  field("version", reference.version);
  field("doi", reference.doi, true);
  field("url", reference.url, true);
  field("note", reference.note);
  return out + "\n}\n";
}

}  // namespace reamsim
