// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "sim/base/text.h"
#include "sim/scenario/key_tree.h"
#include "sim/scenario/paths.h"
#include "sim/scenario/show.h"
#include "sim/study/study_plan.h"

namespace reamsim {

namespace {

constexpr int kMostSamples = 1'000'000;
const std::vector<std::string_view> kSampleKeys{"method", "n", "seed", "of"};
const std::vector<std::string_view> kMethods{"sobol", "latin_hypercube", "monte_carlo", "saltelli"};  // as SampleMethod
const std::vector<std::string_view> kKinds{"normal", "lognormal", "uniform", "tilt_sd_deg", "shift_sd_mm"};  // as Kind

namespace fs = std::filesystem;

constexpr int kStudyVersion = 1;
const std::vector<std::string_view> kStudyKeys{"version", "name", "base", "set", "vary", "table", "sample", "keep"};
const std::vector<std::string_view> kKept{"summary", "forces", "pictures", "vdb"};

class StudyReader {
 public:
  StudyReader(const std::string& path, MistakeList& mistakes) : file_(shown_path(path)), mistakes_(mistakes) {
    const fs::path absolute = fs::absolute(path).lexically_normal();
    folder_ = absolute.parent_path().string();
    study_.file = absolute.string();
    study_.name = absolute.stem().string();
  }

  Study read(const YamlNode& document) {
    if (document.kind != YamlNode::Kind::map) {
      throw InputError({file_, 1, 0}, "", "found " + shown(document),
                       "expected a study with the keys version and base");
    }
    for (const YamlEntry& entry : document.entries) mistakes_.attempt([&] { read_entry(entry); });
    require_keys(document, {"version", "base"}, {file_, 1, 1}, "");
    check_keys_vary_once();
    return std::move(study_);
  }

 private:
  void read_entry(const YamlEntry& entry) {
    const YamlNode& value = *entry.value;
    if (entry.key == "version") return read_version(value);
    if (entry.key == "name") return read_name(value);
    if (entry.key == "base") return read_base(value);
    if (entry.key == "set") return read_set(value);
    if (entry.key == "vary") return read_vary(value);
    if (entry.key == "table") return read_table(value);
    if (entry.key == "keep") return read_keep(value);
    if (entry.key == "sample") return read_sample(value);
    throw InputError(entry.mark.in(file_), shown_key(entry.key), "unknown key", suggest_word(kStudyKeys, entry.key));
  }

  void require_keys(const YamlNode& node, std::initializer_list<const char*> keys, const SourceLocation& where,
                    const std::string& above) {
    for (const char* key : keys) {
      if (node.find(key) == nullptr) mistakes_.add(InputError(where, above + key, "missing", "add it"));
    }
  }

  [[noreturn]] void reject(const YamlNode& node, const std::string& key, const std::string& expected) const {
    throw InputError(node.mark.in(file_), key, "found " + shown(node), expected);
  }

  void read_version(const YamlNode& node) const {
    if (node.text != std::to_string(kStudyVersion)) reject(node, "version", "this program reads version 1");
  }

  /// The name becomes that of a folder.
  void read_name(const YamlNode& node) {
    const bool plain = node.kind == YamlNode::Kind::scalar && !node.text.empty() && node.text.front() != '.' &&
                       node.text.find('/') == std::string::npos;
    if (!plain) reject(node, "name", "expected a name that a folder can have");
    study_.name = node.text;
  }

  void read_base(const YamlNode& node) {
    if (node.kind != YamlNode::Kind::scalar)
      reject(node, "base", "expected a scenario: its path, or the name of a shipped one");
    const SourceLocation where = node.mark.in(file_);
    study_.base = shipped_scenario_of_key(node.text, folder_, where, "base");
    // A folder of the program may have ${ in its name, which only a text of the study replaces.
    if (study_.base == node.text) study_.base = resolve_path(node.text, TextKind::input_file, folder_, where, "base");
  }

  void read_set(const YamlNode& node) {
    if (node.kind != YamlNode::Kind::map) reject(node, "set", "expected \"key: value\" lines");
    for (const YamlEntry& entry : node.entries) {
      mistakes_.attempt([&] {
        const KeyValue value = value_of_node(entry.key, *entry.value, folder_, entry.mark.in(file_));
        study_.set.push_back(entry.key + "=" + value.applied);
        once(entry.key, entry.mark.in(file_));
      });
    }
  }

  void read_vary(const YamlNode& node) {
    if (node.kind != YamlNode::Kind::sequence || node.items.empty()) {
      reject(node, "vary", "expected a list such as \"- motion.plunge.depth_mm: [2, 3]\"");
    }
    for (const YamlNodePtr& item : node.items) mistakes_.attempt([&] { study_.vary.push_back(variation(*item)); });
  }

  Variation variation(const YamlNode& item) {
    if (item.kind != YamlNode::Kind::map) reject(item, "vary", "expected \"key: [values]\", or \"zip: {...}\"");
    const YamlEntry& entry = item.entries.front();
    if (item.entries.size() > 1) {
      throw InputError(item.entries[1].mark.in(file_), "vary", "two keys in one entry of the list",
                       "begin the second with \"- \" to combine both, or write zip: {...} where they vary together");
    }
    if (entry.key == "zip") return zipped(entry);
    Variation out{.keys = {entry.key}, .levels = {}};
    for (const KeyValue& value : values_of(entry)) out.levels.push_back({value});
    return out;
  }

  Variation zipped(const YamlEntry& zip) {
    if (zip.value->kind != YamlNode::Kind::map || zip.value->entries.empty()) {
      reject(*zip.value, "zip", "expected keys with lists of the same length");
    }
    Variation out;
    for (const YamlEntry& entry : zip.value->entries) {
      const std::vector<KeyValue> values = values_of(entry);
      if (out.keys.empty()) out.levels.resize(values.size());
      if (values.size() != out.levels.size()) {
        throw InputError(
            entry.value->mark.in(file_), entry.key, "a list of " + std::to_string(values.size()),
            "expected " + std::to_string(out.levels.size()) + " values, as many as the first key of zip has");
      }
      out.keys.push_back(entry.key);
      for (std::size_t i = 0; i < values.size(); ++i) out.levels[i].push_back(values[i]);
    }
    return out;
  }

  std::vector<KeyValue> values_of(const YamlEntry& entry) {
    if (entry.value->kind != YamlNode::Kind::sequence || entry.value->items.empty()) {
      find_key(entry.key, entry.mark.in(file_));
      reject(*entry.value, entry.key, "expected a list of values");
    }
    once(entry.key, entry.mark.in(file_));
    std::vector<KeyValue> out;
    for (const YamlNodePtr& item : entry.value->items) {
      out.push_back(value_of_node(entry.key, *item, folder_, item->mark.in(file_)));
    }
    return out;
  }

  void read_table(const YamlNode& node) {
    if (node.kind != YamlNode::Kind::scalar) reject(node, "table", "expected the path of a CSV file");
    const std::string path = resolve_path(node.text, TextKind::input_file, folder_, node.mark.in(file_), "table");
    CohortTable table = read_cohort_table(path, folder_, mistakes_);
    for (const std::string& key : table.keys) once(key, node.mark.in(file_));
    study_.table = std::move(table);
  }

  void read_keep(const YamlNode& node) {
    const auto keep = [&](const YamlNode& item) {
      if (item.text == "forces") study_.keep.forces = true;
      if (item.text == "pictures") study_.keep.pictures = true;
      if (item.text == "vdb") study_.keep.grids = true;
      const bool known = item.kind == YamlNode::Kind::scalar && std::ranges::find(kKept, item.text) != kKept.end();
      if (!known) reject(item, "keep", suggest_word(kKept, item.text));
    };
    if (node.kind == YamlNode::Kind::scalar) return keep(node);
    if (node.kind != YamlNode::Kind::sequence)
      reject(node, "keep", "expected a list of summary, forces, pictures, vdb");
    for (const YamlNodePtr& item : node.items) keep(*item);
  }

  void read_sample(const YamlNode& node) {
    if (node.kind != YamlNode::Kind::map) reject(node, "sample", "expected the keys method, n, seed and of");
    study_.sample.emplace();
    for (const YamlEntry& entry : node.entries) mistakes_.attempt([&] { read_sample_entry(entry); });
    require_keys(node, {"n", "of"}, node.mark.in(file_), "sample.");
  }

  void read_sample_entry(const YamlEntry& entry) {
    const YamlNode& node = *entry.value;
    if (entry.key == "method") {
      study_.sample->method_where = node.mark.in(file_);
      const auto found = std::ranges::find(kMethods, node.text);
      if (found == kMethods.end()) reject(node, "sample.method", suggest_word(kMethods, node.text));
      study_.sample->method = static_cast<SampleMethod>(found - kMethods.begin());
    } else if (entry.key == "n") {
      study_.sample->n = static_cast<int>(whole(node, "sample.n", 1, kMostSamples));
    } else if (entry.key == "seed") {
      study_.sample->seed = whole(node, "sample.seed", 0, 1'000'000'000'000);
    } else if (entry.key == "of") {
      read_keys(node);
    } else {
      throw InputError(entry.mark.in(file_), "sample." + shown_key(entry.key), "unknown key",
                       suggest_word(kSampleKeys, entry.key));
    }
  }

  [[nodiscard]] std::uint64_t whole(const YamlNode& node, const std::string& key, std::uint64_t least,
                                    std::uint64_t most) const {
    const auto value = whole_number(node.text);
    if (!value || *value < least || *value > most) {
      reject(node, key, "expected a whole number, " + std::to_string(least) + " to " + std::to_string(most));
    }
    return *value;
  }

  void read_keys(const YamlNode& node) {
    if (node.kind != YamlNode::Kind::map || node.entries.empty()) {
      reject(node, "sample.of",
             "expected keys with distributions, such as \"cutting.normal_ratio: {normal: [0.5, 0.1]}\"");
    }
    for (const YamlEntry& entry : node.entries) mistakes_.attempt([&] { study_.sample->of.push_back(sampled(entry)); });
  }

  [[nodiscard]] SampledKey sampled(const YamlEntry& entry) const {
    const SourceLocation where = entry.mark.in(file_);
    const KeyNode& key = find_key(entry.key, where);
    const YamlNode& node = *entry.value;
    if (node.kind != YamlNode::Kind::map || node.entries.size() != 1) {
      reject(node, entry.key, "expected one distribution, " + join_or(kKinds));
    }
    const YamlEntry& given = node.entries.front();
    const auto kind = std::ranges::find(kKinds, given.key);
    if (kind == kKinds.end()) {
      throw InputError(given.mark.in(file_), entry.key, "unknown distribution " + shown_text(given.key),
                       suggest_word(kKinds, given.key));
    }
    SampledKey out{.key = entry.key, .distribution = {}, .where = where};
    out.distribution.kind = static_cast<Distribution::Kind>(kind - kKinds.begin());
    const KeyKind fitting = out.distribution.dimensions() > 1 ? KeyKind::vector : KeyKind::number;
    if (key.info.kind != fitting) {
      throw InputError(
          where, entry.key, "the distribution does not fit this key",
          "expected a key of a number for normal, lognormal and uniform, and of a vector for tilt_sd_deg and "
          "shift_sd_mm");
    }
    read_parameters(*given.value, entry.key, out.distribution);
    return out;
  }

  void read_parameters(const YamlNode& node, const std::string& key, Distribution& out) const {
    const bool one = out.dimensions() > 1;
    if (!one && node.items.size() != 2) reject(node, key, "expected two numbers, such as [0.5, 0.1]");
    out.a = number(one ? node : *node.items[0], key);
    out.b = one ? 0 : number(*node.items[1], key);
    using Kind = Distribution::Kind;
    if (out.kind == Kind::uniform && !(out.a < out.b)) reject(node, key, "expected the lower end first");
    if (out.kind == Kind::lognormal && !(out.a > 0)) reject(node, key, "expected a median above 0");
    const double spread = one ? out.a : out.b;
    if (out.kind != Kind::uniform && !(spread > 0)) reject(node, key, "expected a standard deviation above 0");
  }

  [[nodiscard]] double number(const YamlNode& node, const std::string& key) const {
    const auto value = node.kind == YamlNode::Kind::scalar ? parse_number(node.text) : std::nullopt;
    if (!value || !std::isfinite(*value)) reject(node, key, "expected a number");
    return *value;
  }

  void once(const std::string& key, const SourceLocation& where) {
    if (!given_.insert(key).second) {
      throw InputError(where, key, "is given twice in the study", "give it in one of set, vary and table");
    }
  }

  /// A sampled key may be varied as well only where the sample is a change of it.
  void check_keys_vary_once() {
    if (!study_.sample) return;
    std::set<std::string> sampled;
    for (const SampledKey& key : study_.sample->of) {
      const bool change = key.distribution.dimensions() > 1;
      if (!sampled.insert(key.key).second || (!change && given_.contains(key.key))) {
        mistakes_.add(InputError(key.where, key.key, "is given twice in the study",
                                 "give it in one of set, vary, table and sample"));
      }
    }
  }

  std::string file_;
  std::string folder_;
  MistakeList& mistakes_;
  Study study_;
  std::set<std::string> given_;
};

}  // namespace

Study read_study(const std::string& path) {
  const YamlNodePtr document = parse_yaml(read_scenario_text(path, YamlLimits::kMaxBytes), shown_path(path));
  MistakeList mistakes;
  Study study = StudyReader(path, mistakes).read(*document);
  mistakes.throw_if_any();
  return study;
}

}  // namespace reamsim
