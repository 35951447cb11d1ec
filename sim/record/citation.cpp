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
#include "sim/record/output_folder.h"
#include "sim/record/result_json.h"
#include "sim/scenario/scenario.h"
#include "sim/scenario/yaml_tree.h"

namespace reamsim {

namespace embedded {
extern const char* const references;
}

namespace {

namespace fs = std::filesystem;

/// A work is an item of CSL-JSON. Its note says what it is cited for, or its licence or checksum.
using Json = nlohmann::ordered_json;

/// What to cite, by what it is cited for.
struct Works {
  std::vector<Json> program, method, data, libraries;
};

constexpr int kReleaseYear = 2026;  // of this version

std::string word_of(const Json& json, const char* key) {
  return json.contains(key) && json[key].is_string() ? json[key].get<std::string>() : "";
}

/// references.json: the works that docs/physics.md, the pages that it lists and docs/engines.md use, and the files that
/// docs/command-line.md names under "Data", by their SHA-256.
const Json& known() {
  static const Json all = Json::parse(embedded::references);
  return all;
}

Json published(const char* id, const std::string& note) {
  const Json& works = known()["works"];
  Json work = *std::find_if(works.begin(), works.end(), [&](const Json& each) { return each["id"] == id; });
  work["note"] = note;
  return work;
}

Json program_work(const std::string& version) {
  const bool current = version == REAMSIM_VERSION;
  Json work{{"id", current ? "reamsim" : "reamsim-" + version},
            {"type", "software"},
            {"title", "reamsim: an offline glenoid-reaming simulator"}};
  work["author"].push_back({{"literal", "the reamsim authors"}});
  if (current) work["issued"]["date-parts"] = Json::array({Json::array({kReleaseYear})});
  if (!version.empty()) work["version"] = version;
  work["note"] = "Apache-2.0";
  return work;
}

bool has_default_density(const YamlNode& scenario) {
  const DensitySettings usual;
  const auto is = [&](const std::string& key, double value) {
    const YamlNode* node = scenario.at("bone.density." + key);
    return node == nullptr || node->text.empty() || std::abs(std::strtod(node->text.c_str(), nullptr) - value) < 1e-12;
  };
  return is("ash_slope_g_cm3_per_hu", usual.ash_slope_g_cm3_per_hu) && is("ash_offset_g_cm3", usual.ash_offset_g_cm3) &&
         is("ash_fraction", usual.ash_fraction);
}

/// Each work once, whatever it is cited for.
void add(const Json& work, std::vector<Json>& list) {
  const auto listed = std::ranges::find_if(list, [&](const Json& each) { return each["id"] == work["id"]; });
  if (listed == list.end()) return list.push_back(work);
  const std::string note = word_of(work, "note"), before = word_of(*listed, "note");
  if (note.find(before) != std::string::npos) {
    (*listed)["note"] = note;
  } else if (before.find(note) == std::string::npos) {
    (*listed)["note"] = before + "; " + note;
  }
}

Json density_work(const YamlNode& scenario) {
  if (has_default_density(scenario))
    return published("knowles2016",
                     "density from radiodensity: the default, of a femur, in Table 1; docs/density.md, 1");
  return {{"id", "density"},
          {"type", "document"},
          {"title", "the source of your relation of density and radiodensity"},
          {"note", "bone.density differs from the default"}};
}

/// Reads the resolved scenario of the run where a citation depends on it.
void add_method(const Json& summary, const std::string& dir, Works& out) {
  const std::string engine = word_of(summary, "engine");
  std::string rebuilt;
  if (engine == "octree") rebuilt = "; the engine is that of Zheng et al., its reference 33, as rebuilt there";
  if (engine == "implicit") rebuilt = "; the engine is that of Yau et al., its reference 32, as rebuilt there";
  add(published("faieghi2020", "voxmap, broad phase and contact" + rebuilt), out.method);
  if (word_of(summary, "erosion") == "exact") {
    add(published("scardovelli2000", "volumes of clipped voxels; docs/density.md, 1, and docs/erosion.md, 3"),
        out.method);
  }
  if (word_of(summary.value("force_law", Json::object()), "preset").starts_with("drill-")) {
    add(published("macavelia2012", "constants of the force; docs/validation.md"), out.method);
  }
  if (summary.contains("segmentation")) {
    add(published("aslam2004", "density of boundary voxels; docs/density.md, 1"), out.method);
    const std::string file = dir + "/scenario.yaml";
    add(density_work(*parse_yaml(read_file(file, "the scenario.yaml of a run"), file)), out.method);
  }
  if (summary.contains("deflection")) {
    add(published("broyden1965", "balance of a tool on springs; docs/feeds.md, 11"), out.method);
  }
}

/// Everything that the run read and reamsim does not ship: bones, label maps, recordings.
void add_data(const Json& summary, Works& out) {
  if (!summary.contains("inputs") || !summary["inputs"].is_array()) return;
  for (const Json& input : summary["inputs"]) {
    const std::string role = word_of(input, "role"), sha256 = word_of(input, "sha256");
    if (role == "scenario" || role.find("tool") != std::string::npos) continue;
    if (const Json& data = known()["data"]; data.contains(sha256)) {
      add(data[sha256], out.data);
      continue;
    }
    const std::string title = role + ", " + fs::path(word_of(input, "path")).filename().string();
    const bool is_listed = std::ranges::any_of(out.data, [&](const Json& other) {
      return sha256.empty() ? other["title"] == title : word_of(other, "note").ends_with(sha256);
    });
    if (is_listed) continue;
    out.data.push_back({{"id", "data" + std::to_string(out.data.size() + 1)},
                        {"type", "dataset"},
                        {"title", title},
                        {"note", "not a data set that reamsim knows: cite its source" +
                                     (sha256.empty() ? std::string() : "; SHA-256 " + sha256)}});
  }
}

void add_libraries(const Json& summary, Works& out) {
  add(published("museth2013", "OpenVDB: grids"), out.libraries);
  add(published("eigen", "linear algebra"), out.libraries);
  if (summary.contains("segmentation")) add(published("mccormick2014", "reading of the CT"), out.libraries);
  const std::string device = word_of(summary, "device");
  if (device.starts_with("pthread") || device.starts_with("cpu") || device.starts_with("basic")) {
    add(published("jaaskelainen2015", "OpenCL on the processor"), out.libraries);
  }
}

/// Adds what the run in `dir` used. Throws InputError where a file of it is damaged.
void add_run(const std::string& dir, Works& out) {
  const Json summary = parse_result_json(read_file(dir + "/summary.json", "the summary of a run"));
  if (!summary.is_object()) refuse_file(dir + "/summary.json", "is damaged", "expected the summary of a run");
  const std::string program = word_of(summary, "program");
  add(program_work(program.substr(std::min(program.size(), program.find(' ') + 1))), out.program);
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

/// What its finished runs used; those of an older plan are not in its table. A damaged run is left out: the study
/// writes its citation, and must not end with it.
Works works_of_study(const std::string& dir) {
  const auto table = runs_in_table(dir);
  Works out;
  for (const std::string& run : finished_runs(dir)) {
    if (table && !table->contains(run)) continue;
    try {
      Works with_run = out;
      add_run(dir + "/runs/" + run, with_run);
      out = std::move(with_run);
    } catch (const InputError&) {
      continue;
    }
  }
  return out;
}

Works works_of_program() {
  return {.program = {program_work(REAMSIM_VERSION)},
          .method = {published("faieghi2020", "voxmap, broad phase and contact")},
          .data = {},
          .libraries = {published("museth2013", "OpenVDB: grids"), published("eigen", "linear algebra")}};
}

/// The authors of a work, each as `write` has it: called with name, group (or "") and what separates it from the last.
template <class Write>
std::string authors_of(const Json& work, const std::string& separator, const Write& write) {
  std::string out;
  if (!work.contains("author")) return out;
  for (const Json& author : work["author"]) {
    const std::string group = word_of(author, "literal");
    const std::string name = group.empty() ? word_of(author, "family") + ", " + word_of(author, "given") : group;
    out += write(name, group, out.empty() ? "" : separator);
  }
  return out;
}

std::string year_of(const Json& work) {
  return work.contains("issued") ? work["issued"]["date-parts"][0][0].dump() : "";
}

const char* journal_key(const Json& work) {
  return work["type"] == "article-journal" ? "container-title" : "publisher";
}

/// One line: authors, year, title, journal, DOI, note.
std::string text_of(const Json& work) {
  const auto author = [](const std::string& name, const std::string& group, const std::string& separator) {
    return group == "et al." ? " et al." : separator + name;
  };
  std::string out = authors_of(work, ", ", author);
  const auto put = [&](const char* before, const std::string& value, const char* after = "") {
    if (!value.empty()) out += before + value + after;
  };
  put(" (", year_of(work), ")");
  out += (out.empty() ? "" : ": ") + word_of(work, "title");
  put(", version ", word_of(work, "version"));
  put(". ", word_of(work, journal_key(work)));
  put(" ", word_of(work, "volume"));
  put(", ", word_of(work, "page"));
  put(". doi:", word_of(work, "DOI"));
  put(". ", word_of(work, "URL"));
  put(" [", word_of(work, "note"), "]");
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

std::string bibtex_of(const Json& work) {
  std::string out = (work["type"] == "article-journal" ? "@article{" : "@misc{") + word_of(work, "id");
  const auto field = [&](const char* name, const std::string& value, bool as_it_is = false) {
    if (!value.empty()) out += std::string(",\n  ") + name + " = " + (as_it_is ? "{" + value + "}" : braced(value));
  };
  const auto author = [](const std::string& name, const std::string& group, const std::string& separator) {
    return separator + (group == "et al." ? "others" : group.empty() ? name : "{" + group + "}");
  };
  field("author", authors_of(work, " and ", author), true);
  field("title", word_of(work, "title"));
  field("year", year_of(work));
  field(work["type"] == "article-journal" ? "journal" : "publisher", word_of(work, journal_key(work)));
  field("volume", word_of(work, "volume"));
  field("pages", word_of(work, "page"));
  field("version", word_of(work, "version"));
  field("doi", word_of(work, "DOI"), true);
  field("url", word_of(work, "URL"), true);
  field("note", word_of(work, "note"));
  return out + "\n}\n";
}

Citation citation_of(const Works& works) {
  const std::pair<const char*, const std::vector<Json>*> sections[] = {
      {"Program", &works.program}, {"Method", &works.method}, {"Data", &works.data}, {"Libraries", &works.libraries}};
  Citation out{.text = "What a publication of these results should cite\n", .bibtex = "", .csl_json = ""};
  Json all = Json::array();
  for (const auto& [title, list] : sections) {
    if (!list->empty()) out.text += std::string("\n") + title + "\n";
    for (const Json& work : *list) {
      out.text += "  " + text_of(work) + "\n";
      out.bibtex += (all.empty() ? "" : "\n") + bibtex_of(work);
      all.push_back(work);
    }
  }
  out.csl_json = all.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  return out;
}

}  // namespace

Citation cite_program() {
  return citation_of(works_of_program());
}

Citation cite_runs(const std::vector<std::string>& dirs) {
  Works out;
  for (const std::string& dir : dirs) add_run(dir, out);
  return citation_of(out);
}

Citation cite_results(const std::string& dir) {
  if (fs::exists(dir + "/summary.json")) return cite_runs({dir});
  if (fs::exists(dir + "/compare.csv")) {
    refuse_file(dir, "holds a comparison, which does not know the folders of its runs",
                std::string("read its ") + kCitationName + ", or give the folders of its runs, one at a time");
  }
  Works out = works_of_study(dir);
  if (out.program.empty()) out = works_of_program();
  if (fs::exists(dir + "/uq.json")) {
    out.method.push_back(published("sobol2001", "sensitivity indices"));
    out.method.push_back(published("saltelli2010", "estimator of the first-order index"));
    out.method.push_back(published("jansen1999", "estimator of the total index"));
  }
  return citation_of(out);
}

void write_citation(const std::string& dir, const Citation& citation) {
  replace_file(dir + "/" + kCitationName, citation.text + "\nBibTeX\n\n" + citation.bibtex);
}

}  // namespace reamsim
