// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <map>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/scenario/key_visitor.h"
#include "sim/scenario/markups.h"
#include "sim/scenario/yaml_tree.h"

namespace reamsim {

/// Keys of points whose value is {markups: FILE, point: LABEL}. Reads each file once.
class MarkupsKeys {
 public:
  /// `folder`: base of relative paths. `file`: name of the scenario in messages.
  MarkupsKeys(std::string file, std::string folder) : file_(std::move(file)), folder_(std::move(folder)) {}

  /// Whether a value names a file of markups, and not numbers.
  static bool are_in(const KeyInfo& info, const YamlNode& node) {
    return info.point && node.kind == YamlNode::Kind::map && node.find("markups") != nullptr;
  }

  /// The point of a value, LPS, mm. Throws InputError with the place of the value, `key`, the file and its labels.
  Vec3 point(const KeyInfo& info, const YamlNode& node, const std::string& key);
  /// The points of a value: those that `point` lists, or all of the file.
  std::vector<Vec3> points(const KeyInfo& info, const YamlNode& node, const std::string& key);

  [[nodiscard]] const std::vector<MarkupsSource>& sources() const { return sources_; }

 private:
  /// What a value asks for.
  struct Request {
    const YamlNode& node;
    const std::string& key;
    std::vector<std::string> labels{};  ///< empty: what the file has
  };

  [[nodiscard]] Request request_of(const YamlNode& node, const std::string& key) const;
  const Markups& file_of(const Request& request);
  void require_range(const KeyInfo& info, const Request& request, const std::vector<Vec3>& found) const;
  void remember(const Request& request, const Markups& markups, std::size_t points);
  template <class Work>
  decltype(auto) located(const Request& request, const Work& work) const;

  std::string file_;
  std::string folder_;
  std::map<std::string, Markups> read_;  // by path
  std::vector<MarkupsSource> sources_;
};

}  // namespace reamsim
