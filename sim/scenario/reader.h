// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/scenario/key_locations.h"
#include "sim/scenario/key_visitor.h"
#include "sim/scenario/markups_keys.h"
#include "sim/scenario/yaml_tree.h"

namespace reamsim {

/// Reads the values of a document whose unknown keys are already reported. Checks each key by itself (type, range,
/// choice, where it applies); check_rules() checks keys against each other. Expands paths and makes them absolute.
///
/// Lists each mistake and continues with the default value. Does not report consequences of a mistake: keys that depend
/// on a wrong or missing choice, missing keys beside an unknown key (probably a typing error), and the contents of a
/// section that is not one.
class ScenarioReader : public KeyVisitor {
 public:
  /// `folder`: base of relative paths. `file`: name in messages. `mistakes` must outlive the reader and hold the
  /// findings of reject_unknown_keys().
  ScenarioReader(YamlNodePtr document, std::string file, std::string folder, MistakeList& mistakes);

  [[nodiscard]] const KeyLocations& locations() const { return locations_; }
  /// The keys read so far whose points come from a file of markups.
  [[nodiscard]] const std::vector<MarkupsSource>& markups() const { return markups_.sources(); }

  void group(const KeyGroup& group) override;
  void defaults(const std::function<void()>& change) override { change(); }

 protected:
  void visit(const KeyInfo& info, const ValuePointer& value) override;
  bool begin_section(const KeyInfo& info) override;
  bool begin_optional_section(const KeyInfo& info, bool has_value) override;
  std::size_t begin_list(const KeyInfo& info, std::size_t size) override;
  void begin_item(std::size_t index) override;
  void end() override;

 private:
  /// A missing key that a choice requires; no mistake where a given key contradicts the choice.
  struct MissingByChoice {
    std::string_view choice;
    InputError error;
  };
  /// The section, list or item being read; its node is null where the document does not have it.
  struct Level {
    YamlNodePtr node;
    std::string path;
    SourceLocation where;
    bool skipped = false;                            // wrong as a whole: its keys are not checked
    bool has_unknown = false;                        // a missing key may be the unknown one
    std::map<std::string_view, std::string> chosen;  // values of the choices read so far
    std::set<std::string_view> unknown_choices;      // choices whose value is wrong or missing
    std::set<std::string_view> contradicted;         // choices that exclude a given key
    std::vector<MissingByChoice> missing;
  };

  enum class Applies { yes, no, unknown };

  /// The value of a key; nullptr where it is absent or cannot be judged. Throws where it is required, or does not
  /// apply.
  YamlNodePtr take(const KeyInfo& info);
  void take_missing(const KeyInfo& info);
  [[nodiscard]] Applies applies(const KeyInfo& info, std::string& why_not) const;
  /// The value that a node holds. Each throws InputError.
  void read(const KeyInfo& info, const YamlNode& node, double& value) const;
  void read(const KeyInfo& info, const YamlNode& node, int& value) const;
  void read(const KeyInfo& info, const YamlNode& node, bool& value) const;
  void read(const KeyInfo& info, const YamlNode& node, std::string& value) const;
  void read(const KeyInfo& info, const YamlNode& node, std::vector<std::string>& values) const;
  void read(const KeyInfo& info, const YamlNode& node, std::optional<Vec3>& value);
  void read(const KeyInfo& info, const YamlNode& node, std::vector<Vec3>& values);
  void read(const KeyInfo& info, const YamlNode& node, std::optional<Quat>& value) const;
  /// Takes a section or list. Returns whether there was no mistake.
  bool take_whole(const KeyInfo& info, YamlNode::Kind kind, YamlNodePtr& node);
  void push(const std::string& path, YamlNodePtr node, bool skipped);
  [[nodiscard]] std::string path_of(std::string_view name) const;
  [[nodiscard]] std::vector<double> components(const KeyInfo& info, const YamlNode& node, std::size_t count) const;
  [[nodiscard]] double checked_number(const KeyInfo& info, const YamlNode& node) const;
  [[nodiscard]] std::string checked_text(const KeyInfo& info, const YamlNode& node) const;
  [[nodiscard]] std::string checked_name(const KeyInfo& info, const YamlNode& node) const;
  /// `found`: "" = the node in words. `more`: behind what the key expects.
  [[noreturn]] void reject(const KeyInfo& info, const YamlNode& node, const std::string& found = "",
                           const std::string& more = "") const;

  std::string file_;
  std::string folder_;
  std::vector<Level> levels_;
  KeyLocations locations_;
  MarkupsKeys markups_;
  MistakeList& mistakes_;
};

}  // namespace reamsim
