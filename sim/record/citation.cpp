// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/citation.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <set>

#include "sim/base/csv.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/record/result_json.h"
#include "sim/scenario/scenario.h"
#include "sim/scenario/yaml_tree.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

using Json = nlohmann::ordered_json;

constexpr int kReleaseYear = 2026;  // of this version

Reference program_reference(const std::string& version) {
  return {.key = version == REAMSIM_VERSION ? "reamsim" : "reamsim-" + version,
          .type = "software",
          .authors = {"the reamsim authors"},
          .title = "reamsim: an offline glenoid-reaming simulator",
          .year = version == REAMSIM_VERSION ? kReleaseYear : 0,
          .version = version,
          .note = "Apache-2.0"};
}

std::string word_of(const Json& json, const char* key) {
  return json.contains(key) && json[key].is_string() ? json[key].get<std::string>() : "";
}

std::string version_of(const Json& summary) {
  const std::string program = word_of(summary, "program");
  return program.substr(std::min(program.size(), program.find(' ') + 1));
}

/// The scalar below `section.key` of a resolved scenario, or "".
std::string scalar_at(YamlNodePtr node, std::initializer_list<const char*> path) {
  for (const char* key : path) {
    const YamlEntry* entry = node->kind == YamlNode::Kind::map ? node->find(key) : nullptr;
    if (entry == nullptr) return "";
    node = entry->value;
  }
  return node->text;
}

bool has_default_density(const YamlNodePtr& scenario) {
  const DensitySettings usual;
  const auto is = [&](const char* key, double value) {
    const std::string text = scalar_at(scenario, {"bone", "density", key});
    return text.empty() || std::abs(std::strtod(text.c_str(), nullptr) - value) < 1e-12;
  };
  return is("ash_slope_g_cm3_per_hu", usual.ash_slope_g_cm3_per_hu) && is("ash_offset_g_cm3", usual.ash_offset_g_cm3) &&
         is("ash_fraction", usual.ash_fraction);
}

/// Each work once, whatever it is cited for.
void add(const Reference& reference, std::vector<Reference>& list) {
  const auto known = std::ranges::find(list, reference.key, &Reference::key);
  if (known == list.end()) {
    list.push_back(reference);
  } else if (reference.note.find(known->note) != std::string::npos) {
    known->note = reference.note;
  } else if (known->note.find(reference.note) == std::string::npos) {
    known->note += "; " + reference.note;
  }
}

void add_density(const YamlNodePtr& scenario, Citation& out) {
  if (has_default_density(scenario)) {
    add(known_reference("pmc5234499", "density from radiodensity: the default, of a femur; docs/density.md, 1"),
        out.method);
  } else {
    add({.key = "density",
         .type = "document",
         .title = "the source of your relation of density and radiodensity",
         .note = "bone.density differs from the default"},
        out.method);
  }
}

/// Reads the resolved scenario of the run where a citation depends on it.
void add_method(const Json& summary, const std::string& dir, Citation& out) {
  const std::string engine = word_of(summary, "engine");
  std::string rebuilt;
  if (engine == "octree") rebuilt = "; the engine is that of Zheng et al., its reference 33, as rebuilt there";
  if (engine == "implicit") rebuilt = "; the engine is that of Yau et al., its reference 32, as rebuilt there";
  add(known_reference("faieghi2020", "voxmap, broad phase and contact" + rebuilt), out.method);
  if (word_of(summary, "erosion") == "exact") {
    add(known_reference("scardovelli2000", "volumes of clipped voxels; docs/density.md, 1, and docs/erosion.md, 3"),
        out.method);
  }
  if (summary.contains("segmentation")) {
    add(known_reference("aslam2004", "density of boundary voxels; docs/density.md, 1"), out.method);
    const std::string file = dir + "/scenario.yaml";
    add_density(parse_yaml(read_file(file, "the scenario.yaml of a run"), file), out);
  }
  if (summary.contains("deflection")) {
    add(known_reference("broyden1965", "balance of a tool on springs; docs/feeds.md, 11"), out.method);
  }
}

/// Everything that the run read and reamsim does not ship: bones, label maps, recordings.
void add_data(const Json& summary, Citation& out) {
  if (!summary.contains("inputs") || !summary["inputs"].is_array()) return;
  for (const Json& input : summary["inputs"]) {
    const std::string role = word_of(input, "role"), sha256 = word_of(input, "sha256");
    if (role == "scenario" || role.find("tool") != std::string::npos) continue;
    Reference data = known_data(sha256);
    if (data.key.empty()) {
      const std::string title = role + ", " + fs::path(word_of(input, "path")).filename().string();
      const auto is_same = [&](const Reference& known) {
        return sha256.empty() ? known.title == title : known.note.ends_with(sha256);
      };
      if (std::ranges::any_of(out.data, is_same)) continue;
      data = {.key = "data" + std::to_string(out.data.size() + 1),
              .type = "dataset",
              .title = title,
              .note = "not a data set that reamsim knows: cite its source" +
                      (sha256.empty() ? std::string() : "; SHA-256 " + sha256)};
    }
    add(data, out.data);
  }
}

void add_libraries(const Json& summary, Citation& out) {
  add(known_reference("museth2013", "OpenVDB: grids"), out.libraries);
  add(known_reference("eigen", "linear algebra"), out.libraries);
  if (summary.contains("segmentation")) add(known_reference("mccormick2014", "reading of the CT"), out.libraries);
  const std::string device = word_of(summary, "device");
  if (device.starts_with("pthread") || device.starts_with("cpu") || device.starts_with("basic")) {
    add(known_reference("jaaskelainen2015", "OpenCL on the processor"), out.libraries);
  }
}

Json summary_of(const std::string& dir) {
  return parse_result_json(read_file(dir + "/summary.json", "the summary of a run"));
}

void add_run(const Json& summary, const std::string& dir, Citation& out) {
  add(program_reference(version_of(summary)), out.program);
  add_method(summary, dir, out);
  add_data(summary, out);
  add_libraries(summary, out);
}

/// The ids of the runs that the table of a study has as done; nothing where it has no table.
std::optional<std::set<std::string, std::less<>>> runs_in_table(const std::string& dir) {
  const std::string table = dir + "/runs.csv";
  if (!fs::exists(table)) return std::nullopt;
  std::ifstream in(table);
  std::set<std::string, std::less<>> out;
  for (std::string line; std::getline(in, line);) {
    const std::vector<std::string_view> cells = csv_cells(line);  // run,id,status
    if (cells.size() > 2 && cells[2] == "done") out.emplace(cells[1]);
  }
  return out;
}

/// The folders of the finished runs of a study. Those of an older plan are not in its table.
std::vector<std::string> runs_of_study(const std::string& dir) {
  const auto table = runs_in_table(dir);
  std::vector<std::string> out;
  std::error_code error;
  for (fs::directory_iterator entry(dir + "/runs", error), end; !error && entry != end; entry.increment(error)) {
    const fs::path& run = entry->path();
    if (run.extension().empty() && (!table || table->contains(run.filename().string()))) out.push_back(run.string());
  }
  std::ranges::sort(out);
  return out;
}

/// A damaged run is left out: the study writes its citation, and must not end with it.
Citation cite_study(const std::string& dir) {
  Citation out;
  for (const std::string& run : runs_of_study(dir)) {
    try {
      const Json summary = summary_of(run);
      if (!summary.is_object()) continue;
      Citation with_run = out;
      add_run(summary, run, with_run);
      out = std::move(with_run);
    } catch (const InputError&) {
      continue;
    }
  }
  return out;
}

/// "Faieghi, M." and a group, as CSL names them.
Json csl_author(const std::string& author) {
  const std::size_t comma = author.find(", ");
  if (comma == std::string::npos) return {{"literal", author == "others" ? "et al." : author}};
  return {{"family", author.substr(0, comma)}, {"given", author.substr(comma + 2)}};
}

Json csl_of(const Reference& reference) {
  Json item{{"id", reference.key}, {"type", reference.type}, {"title", reference.title}};
  for (const std::string& author : reference.authors) item["author"].push_back(csl_author(author));
  if (reference.year > 0) item["issued"]["date-parts"] = Json::array({Json::array({reference.year})});
  const auto set = [&](const char* key, const std::string& value) {
    if (!value.empty()) item[key] = value;
  };
  set(reference.type == "article-journal" ? "container-title" : "publisher", reference.journal);
  set("volume", reference.volume);
  set("page", reference.pages);
  set("version", reference.version);
  set("DOI", reference.doi);
  set("URL", reference.url);
  set("note", reference.note);
  return item;
}

}  // namespace

std::vector<Reference> Citation::all() const {
  std::vector<Reference> out = program;
  for (const auto* list : {&method, &data, &libraries}) out.insert(out.end(), list->begin(), list->end());
  return out;
}

Citation cite_program() {
  return {.program = {program_reference(REAMSIM_VERSION)},
          .method = {known_reference("faieghi2020", "voxmap, broad phase and contact")},
          .data = {},
          .libraries = {known_reference("museth2013", "OpenVDB: grids"), known_reference("eigen", "linear algebra")}};
}

Citation cite_runs(const std::vector<std::string>& dirs) {
  Citation out;
  for (const std::string& dir : dirs) {
    const Json summary = summary_of(dir);
    if (!summary.is_object()) {
      throw InputError({dir + "/summary.json", 0, 0}, "", "is damaged", "expected the summary of a run");
    }
    add_run(summary, dir, out);
  }
  return out;
}

Citation cite_results(const std::string& dir) {
  if (fs::exists(dir + "/summary.json")) return cite_runs({dir});
  if (fs::exists(dir + "/compare.csv")) {
    throw InputError({dir, 0, 0}, "", "holds a comparison, which does not know the folders of its runs",
                     std::string("read its ") + kCitationName + ", or give the folders of its runs, one at a time");
  }
  Citation out = cite_study(dir);
  if (out.program.empty()) out = cite_program();
  if (fs::exists(dir + "/uq.json")) {
    out.method.push_back(known_reference("sobol2001", "sensitivity indices"));
    out.method.push_back(known_reference("saltelli2010", "estimator of the first-order index"));
    out.method.push_back(known_reference("jansen1999", "estimator of the total index"));
  }
  return out;
}

std::string text_of(const Citation& citation) {
  std::string out = "What a publication of these results should cite\n";
  const std::pair<const char*, const std::vector<Reference>*> sections[] = {{"Program", &citation.program},
                                                                            {"Method", &citation.method},
                                                                            {"Data", &citation.data},
                                                                            {"Libraries", &citation.libraries}};
  for (const auto& [title, list] : sections) {
    if (!list->empty()) out += std::string("\n") + title + "\n";
    for (const Reference& reference : *list) out += "  " + text_of(reference) + "\n";
  }
  return out;
}

std::string bibtex_of(const Citation& citation) {
  std::string out;
  for (const Reference& reference : citation.all()) out += (out.empty() ? "" : "\n") + bibtex_of(reference);
  return out;
}

std::string csl_json_of(const Citation& citation) {
  Json list = Json::array();
  for (const Reference& reference : citation.all()) list.push_back(csl_of(reference));
  return list.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void write_citation(const std::string& dir, const Citation& citation) {
  replace_file(dir + "/" + kCitationName, text_of(citation) + "\nBibTeX\n\n" + bibtex_of(citation));
}

}  // namespace reamsim
