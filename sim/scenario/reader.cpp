// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "sim/base/text.h"
#include "sim/scenario/markups.h"
#include "sim/scenario/parse_steps.h"
#include "sim/scenario/paths.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

/// Lists every key of a document that the tree does not have, with the key that was probably meant.
void reject_unknown_keys(const YamlNode& node, const KeyNode& section, const std::string& path, const std::string& file,
                         MistakeList& mistakes) {
  for (const YamlEntry& entry : node.entries) {
    const std::string entry_path = path + (path.empty() ? "" : ".") + shown_key(entry.key);
    const KeyNode* key = section.find(entry.key);
    if (key == nullptr) {
      mistakes.add(InputError(entry.mark.in(file), entry_path, "unknown key", suggest_key(section, entry.key)));
      continue;
    }
    if (key->info.kind == KeyKind::section) reject_unknown_keys(*entry.value, *key, entry_path, file, mistakes);
    if (key->info.kind != KeyKind::list) continue;
    for (std::size_t i = 0; i < entry.value->items.size(); ++i)
      reject_unknown_keys(*entry.value->items[i], *key, entry_path + "." + std::to_string(i), file, mistakes);
  }
}

class ScenarioReader : public KeyVisitor {
 public:
  ScenarioReader(YamlNodePtr document, std::string file, std::string folder, MistakeList& mistakes)
      : file_(std::move(file)), folder_(std::move(folder)), markups_(file_, folder_), mistakes_(mistakes) {
    levels_.push_back({.node = std::move(document), .where = {file_, 0, 0}, .has_unknown = mistakes.has_key_in("")});
  }

  [[nodiscard]] const KeyLocations& locations() const { return locations_; }
  [[nodiscard]] const std::vector<MarkupsSource>& markups() const { return markups_.sources(); }

  void group(const KeyGroup& group) override {
    const Level& level = levels_.back();
    if (level.skipped) return;
    std::vector<std::string_view> found;
    SourceLocation second;
    for (const auto name : group.names) {
      const YamlEntry* entry = level.node ? level.node->find(name) : nullptr;
      if (entry == nullptr) continue;
      found.push_back(name);
      second = entry->mark.in(file_);
    }
    if (found.size() > 1) {
      mistakes_.add(InputError(second, path_of(found.back()), "given together with " + std::string(found.front()),
                               "expected one of " + join_or(group.names)));
    } else if (found.empty() && group.one_needed && !level.has_unknown) {
      mistakes_.add(InputError(level.where, level.path, "needs either " + join_or(group.names), ""));
    }
  }
  void defaults(const std::function<void()>& change) override { change(); }

 protected:
  void visit(const KeyInfo& info, const ValuePointer& value) override {
    const bool fine = mistakes_.attempt([&] {
      const YamlNodePtr node = take(info);
      if (node) std::visit([&](auto* target) { read(info, *node, *target); }, value);
    });
    if (info.kind != KeyKind::text || info.choices.empty()) return;
    Level& level = levels_.back();
    if (!fine || level.skipped) level.unknown_choices.insert(info.name);
    level.chosen[info.name] = *std::get<std::string*>(value);
  }
  void end() override {
    for (const auto& [choice, error] : levels_.back().missing) {
      if (!levels_.back().contradicted.contains(choice)) mistakes_.add(error);
    }
    levels_.pop_back();
  }
  bool begin_section(const KeyInfo& info) override {
    YamlNodePtr node;
    const bool fine = take_whole(info, YamlNode::Kind::map, node);
    std::string why_not;
    if (applies(info, why_not) != Applies::yes) return false;
    // The keys of a required section that is missing are not missing as well.
    push(path_of(info.name), node, !fine || (info.required && !node));
    return true;
  }
  bool begin_optional_section(const KeyInfo& info, bool) override {
    const Level& level = levels_.back();
    if (level.node && level.node->find(info.name) != nullptr) return begin_section(info);
    mistakes_.attempt([&] { take(info); });
    return false;
  }
  std::size_t begin_list(const KeyInfo& info, std::size_t) override {
    YamlNodePtr node;
    const bool fine = take_whole(info, YamlNode::Kind::sequence, node);
    push(path_of(info.name), node, !fine);
    return node ? node->items.size() : 0;
  }
  void begin_item(std::size_t index) override {
    const YamlNodePtr item = levels_.back().node->items[index];
    const std::string path = path_of(std::to_string(index));
    const SourceLocation where = item->mark.in(file_);
    locations_.set(path, where, true);
    const bool wrong = item->kind != YamlNode::Kind::map;
    push(path, wrong ? nullptr : item, wrong);
    if (wrong) mistakes_.add(InputError(where, path, "found " + shown(*item), "expected a section of keys"));
  }

 private:
  /// The section, list or item being read; its node is null where the document does not have it.
  struct Level {
    YamlNodePtr node;
    std::string path{};
    SourceLocation where;
    bool skipped = false;                              // wrong as a whole: its keys are not checked
    bool has_unknown = false;                          // a missing key may be the unknown one
    std::map<std::string_view, std::string> chosen{};  // values of the choices read so far
    std::set<std::string_view> unknown_choices{};      // choices whose value is wrong or missing
    std::set<std::string_view> contradicted{};         // choices that exclude a given key
    /// Missing keys that a choice requires; no mistakes where a given key contradicts the choice.
    std::vector<std::pair<std::string_view, InputError>> missing{};
  };

  enum class Applies { yes, no, unknown };

  std::string path_of(std::string_view name) const {
    const std::string& path = levels_.back().path;
    return path + (path.empty() ? "" : ".") + std::string(name);
  }
  /// `found`: "" = the node in words. `more`: behind what the key expects.
  [[noreturn]] void reject(const KeyInfo& info, const YamlNode& node, const std::string& found = "",
                           const std::string& more = "") const {
    throw InputError(node.mark.in(file_), path_of(info.name), "found " + (found.empty() ? shown(node) : found),
                     "expected " + expectation(info) + more);
  }
  Applies applies(const KeyInfo& info, std::string& why_not) const {
    const Level& level = levels_.back();
    if (!info.when.values.empty()) {
      if (level.unknown_choices.contains(info.when.choice)) return Applies::unknown;
      const auto chosen = level.chosen.find(info.when.choice);
      const std::string value = chosen == level.chosen.end() ? "" : chosen->second;
      if (std::ranges::find(info.when.values, value) == info.when.values.end()) {
        why_not = std::string(info.when.choice) + " is " + value + "; expected it with " +
                  std::string(info.when.choice) + ": " + join_or(info.when.values) + " only";
        return Applies::no;
      }
    }
    if (!info.unless.empty() && level.node && level.node->find(info.unless) != nullptr) {
      why_not = std::string(info.unless) + " is given; expected one or the other";
      return Applies::no;
    }
    return Applies::yes;
  }
  void take_missing(const KeyInfo& info) {
    Level& level = levels_.back();
    const std::string expected = info.choices.empty() ? std::string(info.doc) : expectation(info);
    const InputError error(level.where, path_of(info.name), "missing", "expected this key: " + expected);
    if (!info.choices.empty()) level.unknown_choices.insert(info.name);
    if (level.has_unknown) return;
    if (info.when.values.empty()) throw error;
    level.missing.emplace_back(info.when.choice, error);
  }
  /// The value of a key; nullptr where it is absent or cannot be judged. Throws: missing, or does not apply.
  YamlNodePtr take(const KeyInfo& info) {
    Level& level = levels_.back();
    const YamlEntry* entry = level.node ? level.node->find(info.name) : nullptr;
    const std::string path = path_of(info.name);
    const SourceLocation where = entry == nullptr ? level.where : entry->mark.in(file_);
    locations_.set(path, where, entry != nullptr);
    std::string why_not;
    const Applies fits = applies(info, why_not);
    if (level.skipped || fits == Applies::unknown) return nullptr;
    if (entry == nullptr) {
      if (level.has_unknown) mistakes_.doubt(path);
      if (info.required && fits == Applies::yes) take_missing(info);
      return nullptr;
    }
    if (fits == Applies::yes) return entry->value;
    if (!info.when.values.empty()) level.contradicted.insert(info.when.choice);
    throw InputError(where, path, "does not apply: " + why_not, "");
  }
  double checked_number(const KeyInfo& info, const YamlNode& node) const {
    const bool plain = node.kind == YamlNode::Kind::scalar && !node.quoted;
    const std::optional<double> value = plain ? parse_number(node.text) : std::nullopt;
    if (!value) reject(info, node);
    if (!std::isfinite(*value)) reject(info, node, shown(node) + ", which is not finite");
    if (!info.range.contains(*value)) reject(info, node);
    return *value + 0.0;  // never a negative zero
  }
  void read(const KeyInfo& info, const YamlNode& node, double& value) const { value = checked_number(info, node); }
  void read(const KeyInfo& info, const YamlNode& node, int& value) const {
    const double number = checked_number(info, node);
    if (node.text.find_first_not_of("+-0123456789") != std::string::npos) reject(info, node);
    value = static_cast<int>(number);
  }
  void read(const KeyInfo& info, const YamlNode& node, bool& value) const {
    const bool plain = node.kind == YamlNode::Kind::scalar && !node.quoted;
    if (!plain || (node.text != "true" && node.text != "false")) reject(info, node);
    value = node.text == "true";
  }
  std::string checked_text(const KeyInfo& info, const YamlNode& node) const {
    if (node.kind != YamlNode::Kind::scalar) reject(info, node);
    const bool number = !info.number_too && parse_number(node.text);
    const bool other_type =
        !node.quoted && !node.mark.override_text && (number || node.text == "true" || node.text == "false");
    if (other_type) reject(info, node, "", " (in quotes where it looks like a number)");
    if (node.text.empty() && info.text != TextKind::output_folder) reject(info, node, "\"\"");
    if (!is_printable(node.text)) reject(info, node, "", " without line breaks or control characters");
    return node.text;
  }
  void read(const KeyInfo& info, const YamlNode& node, std::string& value) const {
    const std::string text = checked_text(info, node);
    const bool known = info.choices.empty() || std::ranges::find(info.choices, text) != info.choices.end();
    if (!known) reject(info, node);
    const SourceLocation where = node.mark.in(file_);
    value = info.text == TextKind::word ? text : resolve_path(text, info.text, folder_, where, path_of(info.name));
  }
  std::string checked_name(const KeyInfo& info, const YamlNode& node) const {
    const bool plain_number = node.kind == YamlNode::Kind::scalar && !node.quoted && parse_number(node.text);
    if (plain_number && !is_whole_number(node.text)) reject(info, node);
    KeyInfo name = info;
    name.kind = KeyKind::text;
    name.number_too = true;
    return checked_text(name, node);
  }
  void read(const KeyInfo& info, const YamlNode& node, std::vector<std::string>& values) const {
    std::vector<std::string> found;
    const auto add = [&](const YamlNode& item) {
      if (info.kind == KeyKind::names) return found.push_back(checked_name(info, item));
      const bool known =
          item.kind == YamlNode::Kind::scalar && std::ranges::find(info.choices, item.text) != info.choices.end();
      if (!known) reject(info, item);
      if (std::ranges::find(found, item.text) != found.end()) reject(info, item, item.text + " twice", ", each once");
      found.push_back(item.text);
    };
    if (node.kind == YamlNode::Kind::sequence) {
      if (node.items.empty()) reject(info, node);
      for (const YamlNodePtr& item : node.items) add(*item);
    } else {
      if (info.kind == KeyKind::choices) reject(info, node);
      add(node);
    }
    values = found;
  }
  std::vector<double> components(const KeyInfo& info, const YamlNode& node, std::size_t count) const {
    if (node.kind != YamlNode::Kind::sequence || node.items.size() != count) reject(info, node);
    std::vector<double> out;
    for (const YamlNodePtr& item : node.items) out.push_back(checked_number(info, *item));
    return out;
  }
  void read(const KeyInfo& info, const YamlNode& node, std::optional<Vec3>& value) {
    if (MarkupsKeys::are_in(info, node)) {
      value = markups_.points(info, node, path_of(info.name), false).front();
      return;
    }
    const std::vector<double> numbers = components(info, node, 3);
    const Vec3 found(numbers[0], numbers[1], numbers[2]);
    // Shorter than this, squared lengths lose their digits.
    constexpr double kShortest = 1e-9;
    if (info.nonzero && found.norm() < kShortest) reject(info, node, "a direction of length 0");
    value = found;
  }
  void read(const KeyInfo& info, const YamlNode& node, std::vector<Vec3>& values) {
    if (MarkupsKeys::are_in(info, node)) {
      values = markups_.points(info, node, path_of(info.name), true);
      return;
    }
    if (node.kind != YamlNode::Kind::sequence || std::ssize(node.items) < info.least_points) reject(info, node);
    values.clear();
    for (const YamlNodePtr& item : node.items) {
      std::optional<Vec3> point;
      read(info, *item, point);
      values.push_back(*point);
    }
  }
  void read(const KeyInfo& info, const YamlNode& node, std::optional<Quat>& value) const {
    const std::vector<double> n = components(info, node, 4);
    Quat q(n[0], n[1], n[2], n[3]);
    constexpr double kLengthTolerance = 1.0000001e-2;  // of one written with few digits; 1.01 is within it
    if (std::abs(q.norm() - 1) > kLengthTolerance) reject(info, node, "4 numbers of length " + number_text(q.norm()));
    // A quaternion that is as unit as doubles allow stays as it is, so that to_yaml() and back changes nothing.
    constexpr double kRounding = 1e-14;
    if (std::abs(q.norm() - 1) > kRounding) q.normalize();
    value = q;
  }
  void push(const std::string& path, YamlNodePtr node, bool skipped) {
    levels_.push_back({.node = std::move(node),
                       .path = path,
                       .where = locations_.of(path),
                       .skipped = skipped || levels_.back().skipped,
                       .has_unknown = mistakes_.has_key_in(path)});
  }
  /// Takes a section or list. Returns whether there was no mistake.
  bool take_whole(const KeyInfo& info, YamlNode::Kind kind, YamlNodePtr& node) {
    return mistakes_.attempt([&] {
      const YamlNodePtr found = take(info);
      if (found && found->kind != kind) reject(info, *found);
      node = found;
    });
  }

  std::string file_;
  std::string folder_;
  std::vector<Level> levels_;
  KeyLocations locations_;
  MarkupsKeys markups_;
  MistakeList& mistakes_;
};

}  // namespace

void read_keys(const YamlNodePtr& document, const std::string& file, const std::string& folder,
               void (*describe)(KeyVisitor&, Scenario&), Scenario& scenario, MistakeList& mistakes) {
  reject_unknown_keys(*document, key_tree(), "", file, mistakes);
  ScenarioReader reader(document, file, folder, mistakes);
  describe(reader, scenario);
  scenario.keys = reader.locations();
  scenario.markups = reader.markups();
}

}  // namespace reamsim
