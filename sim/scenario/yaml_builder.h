// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/mark.h>

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "sim/scenario/yaml_tree.h"

namespace reamsim {

/// Begins of the lines of a text, to convert yaml-cpp's marks (from 0, columns in bytes).
class LineIndex {
 public:
  explicit LineIndex(std::string_view text);
  [[nodiscard]] YamlMark mark(int line, int byte_column) const;
  /// The first tab in the indentation of a line (from 0); line 0 of the mark when there is none.
  [[nodiscard]] YamlMark tab_in_indentation(int line) const;

 private:
  std::string_view text_;
  std::vector<std::size_t> starts_;
};

/// Builds the tree of one document from yaml-cpp's events. Unlike yaml-cpp's own tree, it reports duplicate keys,
/// recursive aliases and the size after merging.
class YamlBuilder : public YAML::EventHandler {
 public:
  YamlBuilder(const LineIndex& lines, std::string file) : lines_(lines), file_(std::move(file)) {}

  [[nodiscard]] YamlNodePtr root() const { return root_; }
  /// Begin of the innermost open list or section; line 0 where none is open.
  [[nodiscard]] YamlMark open_mark() const;

  void OnDocumentStart(const YAML::Mark& mark) override;
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override;
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override;
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override;
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value style) override;
  void OnSequenceEnd() override;
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value style) override;
  void OnMapEnd() override;

 private:
  /// An open list or section.
  struct Open {
    std::shared_ptr<YamlNode> node;
    YAML::anchor_t anchor = 0;
    std::string key;  // a map's key without its value yet
    YamlMark key_mark;
    bool has_key = false;
    std::vector<YamlNodePtr> merges;  // values of "<<"
  };

  void open(YamlNode::Kind kind, const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor);
  void close();
  void add(const YamlNodePtr& node, const YamlMark& mark);
  void add_to_map(Open& map, const YamlNodePtr& node, const YamlMark& mark);
  void merge(Open& map);
  void merge_one(YamlNode& map, const YamlNodePtr& from);
  void count(std::size_t nodes, const YamlMark& mark);
  void require_no_tag(const std::string& tag, const YamlMark& mark) const;
  [[nodiscard]] YamlMark mark_of(const YAML::Mark& mark) const { return lines_.mark(mark.line, mark.column); }
  [[noreturn]] void fail(const YamlMark& mark, const std::string& found, const std::string& expected) const;

  const LineIndex& lines_;
  std::string file_;
  std::vector<Open> open_;
  std::map<YAML::anchor_t, YamlNodePtr> anchors_;
  YamlNodePtr root_;
  std::size_t nodes_ = 0;
  int documents_ = 0;
};

}  // namespace reamsim
