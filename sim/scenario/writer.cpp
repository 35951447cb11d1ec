// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "sim/scenario/key_tree.h"
#include "sim/scenario/parse.h"
#include "sim/scenario/paths.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

/// Writes every key that applies, in the order of the description.
class YamlWriter : public KeyVisitor {
 public:
  /// `path_text`: how paths are written.
  explicit YamlWriter(std::function<std::string(const std::string&)> path_text) : path_text_(std::move(path_text)) {}

  [[nodiscard]] const std::string& yaml() const { return out_; }

  void group(const KeyGroup&) override {}

 protected:
  void visit(const KeyInfo& info, const ValuePointer& value) override {
    if (info.kind == KeyKind::text && !info.choices.empty())
      levels_.back().given[info.name] = *std::get<std::string*>(value);
    const std::string text = value_text(info, value, [&](const std::string& word) {
      return yaml_scalar(info.text == TextKind::word ? word : path_text_(word));
    });
    if (!text.empty() && applies(info)) line(info, text);
  }
  bool begin_section(const KeyInfo& info) override {
    if (!applies(info)) return false;
    begin(info, true);
    return true;
  }
  bool begin_optional_section(const KeyInfo& info, bool has_value) override { return has_value && begin_section(info); }
  std::size_t begin_list(const KeyInfo& info, std::size_t size) override {
    const bool written = size > 0 && applies(info);
    begin(info, written);
    return written ? size : 0;
  }
  void begin_item(std::size_t) override {
    item_ = pending_.size();
    levels_.push_back({.given = {}, .begin = pending_.size()});
  }
  void end() override {
    pending_.resize(std::min(pending_.size(), levels_.back().begin));  // nothing was written of it
    levels_.pop_back();
  }

 private:
  struct Level {
    std::map<std::string_view, std::string> given;  // choices, sections and lists written so far
    std::size_t begin = 0;                          // of its heading in pending_
  };

  void begin(const KeyInfo& info, bool written) {
    const std::size_t begin = pending_.size();
    if (written) {
      levels_.back().given[info.name] = "given";
      pending_ += indent() + std::string(info.name) + ":\n";
    }
    levels_.push_back({.given = {}, .begin = begin});
  }
  [[nodiscard]] std::string indent() const { return std::string(2 * (levels_.size() - 1), ' '); }
  [[nodiscard]] bool applies(const KeyInfo& info) const {
    const auto& given = levels_.back().given;
    if (!info.unless.empty() && given.contains(info.unless)) return false;
    if (info.when.values.empty()) return true;
    const auto chosen = given.find(info.when.choice);
    return chosen != given.end() && std::ranges::find(info.when.values, chosen->second) != info.when.values.end();
  }
  void line(const KeyInfo& info, const std::string& value) {
    std::string lines = std::exchange(pending_, "") + indent() + std::string(info.name) + ": " + value + "\n";
    if (const auto item = std::exchange(item_, std::nullopt)) {
      lines.replace(lines.find_first_not_of(' ', *item) - 2, 2, "- ");  // the item's first line, perhaps a heading
    }
    out_ += lines;
  }

  std::function<std::string(const std::string&)> path_text_;
  std::string out_;
  std::string pending_;              // headings of sections whose first key has not come yet
  std::optional<std::size_t> item_;  // where an item begins in pending_, until its first key has come
  std::vector<Level> levels_{1};
};

}  // namespace

std::string to_yaml(const Scenario& scenario) {
  return to_yaml(scenario, recorded_path);
}

std::string to_yaml(const Scenario& scenario, const std::function<std::string(const std::string&)>& path_text) {
  YamlWriter writer(path_text);
  Scenario copy = scenario;
  describe_scenario(writer, copy);
  return writer.yaml();
}

}  // namespace reamsim
