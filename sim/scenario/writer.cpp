// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "sim/base/text.h"
#include "sim/scenario/key_visitor.h"
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

  void number(const KeyInfo& info, double& value) override { line(info, number_text(value)); }
  void integer(const KeyInfo& info, int& value) override { line(info, std::to_string(value)); }
  void flag(const KeyInfo& info, bool& value) override { line(info, value ? "true" : "false"); }

  void text(const KeyInfo& info, std::string& value) override {
    if (!info.choices.empty()) levels_.back()[info.name] = value;
    if (value.empty() && info.text != TextKind::output_folder) return;
    line(info,
         info.number_too ? name_scalar(value) : yaml_scalar(info.text == TextKind::word ? value : path_text_(value)));
  }

  void names(const KeyInfo& info, std::vector<std::string>& values) override {
    std::string list;
    for (const auto& value : values) list += (list.empty() ? "" : ", ") + name_scalar(value);
    line(info, values.size() == 1 ? list : "[" + list + "]");
  }

  void choices(const KeyInfo& info, std::vector<std::string>& values) override {
    std::string list;
    for (const auto& value : values) list += (list.empty() ? "" : ", ") + yaml_scalar(value);
    line(info, "[" + list + "]");
  }

  void vector(const KeyInfo& info, Vec3& value) override {
    line(info, "[" + number_text(value.x()) + ", " + number_text(value.y()) + ", " + number_text(value.z()) + "]");
  }
  void optional_vector(const KeyInfo& info, std::optional<Vec3>& value) override {
    if (value) vector(info, *value);
  }
  void points(const KeyInfo& info, std::vector<Vec3>& values) override {
    if (values.empty()) return;
    std::string list;
    for (const Vec3& p : values) {
      list += (list.empty() ? "[" : ", [") + number_text(p.x()) + ", " + number_text(p.y()) + ", " +
              number_text(p.z()) + "]";
    }
    line(info, "[" + list + "]");
  }
  void optional_quaternion(const KeyInfo& info, std::optional<Quat>& value) override {
    if (!value) return;
    line(info, "[" + number_text(value->w()) + ", " + number_text(value->x()) + ", " + number_text(value->y()) + ", " +
                   number_text(value->z()) + "]");
  }
  void group(const KeyGroup&) override {}

 protected:
  bool begin_section(const KeyInfo& info) override {
    if (!applies(info)) return false;
    levels_.back()[info.name] = "given";
    pending_ += indent() + std::string(info.name) + ":\n";
    levels_.emplace_back();
    return true;
  }
  bool begin_optional_section(const KeyInfo& info, bool has_value) override { return has_value && begin_section(info); }
  void end_section() override {
    levels_.pop_back();
    pending_.clear();  // a section of which nothing was written
  }

  std::size_t begin_list(const KeyInfo& info, std::size_t size) override {
    const bool skipped = size == 0 || !applies(info);
    if (!skipped) {
      levels_.back()[info.name] = "given";
      pending_ += indent() + std::string(info.name) + ":\n";
    }
    levels_.emplace_back();
    return skipped ? 0 : size;
  }
  void begin_item(std::size_t) override {
    levels_.emplace_back();
    item_ = pending_.size();
  }
  void end_list() override { levels_.pop_back(); }

 private:
  /// A whole number stays one.
  static std::string name_scalar(const std::string& value) {
    return is_whole_number(value) ? value : yaml_scalar(value);
  }

  using Level = std::map<std::string_view, std::string>;  // choices, sections and lists written so far

  [[nodiscard]] std::string indent() const { return std::string(2 * (levels_.size() - 1), ' '); }

  [[nodiscard]] bool applies(const KeyInfo& info) const {
    const Level& level = levels_.back();
    if (!info.unless.empty() && level.contains(info.unless)) return false;
    if (info.when.values.empty()) return true;
    const auto chosen = level.find(info.when.choice);
    return chosen != level.end() && std::ranges::find(info.when.values, chosen->second) != info.when.values.end();
  }

  void line(const KeyInfo& info, const std::string& value) {
    if (!applies(info)) return;
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
