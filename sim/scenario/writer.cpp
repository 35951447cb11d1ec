// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <map>
#include <utility>

#include "sim/scenario/key_tree.h"
#include "sim/scenario/parse.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

/// Writes every key that applies, in the order of the description.
class YamlWriter : public KeyVisitor {
 public:
  /// `path_text`: how paths are written.
  explicit YamlWriter(std::function<std::string(const std::string&)> path_text) : path_text_(std::move(path_text)) {}

  [[nodiscard]] const std::string& yaml() const { return levels_.front().text; }

 protected:
  void visit(const KeyInfo& info, const ValuePointer& value) override {
    Level& level = levels_.back();
    if (info.kind == KeyKind::text && !info.choices.empty()) level.given[info.name] = *std::get<std::string*>(value);
    const std::string text = value_text(info, value, [&](const std::string& word) {
      return yaml_scalar(info.text == TextKind::word ? word : path_text_(word));
    });
    if (!text.empty() && applies(info)) level.text += indent() + std::string(info.name) + ": " + text + "\n";
  }
  bool begin_section(const KeyInfo& info) override {
    if (!applies(info)) return false;
    levels_.back().given[info.name] = "given";
    levels_.push_back({.heading = indent() + std::string(info.name) + ":\n"});
    return true;
  }
  bool begin_optional_section(const KeyInfo& info, bool has_value) override { return has_value && begin_section(info); }
  std::size_t begin_list(const KeyInfo& info, std::size_t size) override {
    if (size > 0 && begin_section(info)) return size;
    levels_.emplace_back();
    return 0;
  }
  void begin_item(std::size_t) override { levels_.emplace_back(); }
  void end() override {
    Level done = std::move(levels_.back());
    levels_.pop_back();
    if (done.text.empty()) return;
    if (done.heading.empty()) done.text.replace(done.text.find_first_not_of(' ') - 2, 2, "- ");  // an item
    levels_.back().text += done.heading + done.text;
  }

 private:
  struct Level {
    std::string heading{};                            // of an item ""
    std::string text{};                               // what was written of it
    std::map<std::string_view, std::string> given{};  // choices, sections and lists written so far
  };

  [[nodiscard]] std::string indent() const { return std::string(2 * (levels_.size() - 1), ' '); }
  [[nodiscard]] bool applies(const KeyInfo& info) const {
    const auto& given = levels_.back().given;
    if (!info.unless.empty() && given.contains(info.unless)) return false;
    if (info.when.values.empty()) return true;
    const auto chosen = given.find(info.when.choice);
    return chosen != given.end() && std::ranges::find(info.when.values, chosen->second) != info.when.values.end();
  }

  std::function<std::string(const std::string&)> path_text_;
  std::vector<Level> levels_{1};
};

}  // namespace

std::string to_yaml(const Scenario& scenario, const std::function<std::string(const std::string&)>& path_text) {
  YamlWriter writer(path_text);
  Scenario copy = scenario;
  describe_scenario(writer, copy);
  return writer.yaml();
}

}  // namespace reamsim
