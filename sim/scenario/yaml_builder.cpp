// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/yaml_builder.h"

#include <yaml-cpp/emitterstyle.h>

#include <algorithm>
#include <set>

#include "sim/scenario/show.h"

namespace reamsim {

LineIndex::LineIndex(std::string_view text) : text_(text), starts_{0} {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\n') starts_.push_back(i + 1);
  }
}

YamlMark LineIndex::mark(int line, int byte_column) const {
  if (line < 0 || byte_column < 0) return {};
  const std::size_t start = starts_[std::min(static_cast<std::size_t>(line), starts_.size() - 1)];
  const std::string_view before = text_.substr(start, static_cast<std::size_t>(byte_column));
  const auto characters = std::ranges::count_if(before, [](char c) { return (c & 0xC0) != 0x80; });
  return {line + 1, static_cast<int>(characters) + 1, nullptr};
}

YamlMark LineIndex::tab_in_indentation(int line) const {
  if (line < 0 || static_cast<std::size_t>(line) >= starts_.size()) return {};
  const std::size_t start = starts_[static_cast<std::size_t>(line)];
  const std::size_t tab = text_.find_first_not_of(' ', start);
  const bool found = tab != std::string_view::npos && text_[tab] == '\t';
  return found ? mark(line, static_cast<int>(tab - start)) : YamlMark{};
}

void YamlBuilder::fail(const YamlMark& mark, const std::string& found, const std::string& expected) const {
  throw InputError(mark.in(file_), "", found, expected);
}

YamlMark YamlBuilder::open_mark() const {
  return open_.empty() ? YamlMark{} : open_.back().node->mark;
}

void YamlBuilder::OnDocumentStart(const YAML::Mark& mark) {
  if (++documents_ > 1) fail(mark_of(mark), "a second YAML document begins here", "expected one document per file");
}

void YamlBuilder::count(std::size_t nodes, const YamlMark& mark) {
  nodes_ += nodes;
  if (nodes_ > YamlLimits::kMaxNodes) {
    fail(mark, "more than " + std::to_string(YamlLimits::kMaxNodes) + " values",
         "reduce the file (put long recordings into motion.csv)");
  }
}

void YamlBuilder::require_no_tag(const std::string& tag, const YamlMark& mark) const {
  if (tag.empty() || tag == "?" || tag == "!") return;
  fail(mark, "found the YAML tag " + shown_text(tag), "expected a value without a tag");
}

void YamlBuilder::OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) {
  auto node = std::make_shared<YamlNode>();
  node->mark = mark_of(mark);
  if (anchor != 0) anchors_[anchor] = node;
  add(node, node->mark);
}

void YamlBuilder::OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                           const std::string& value) {
  auto node = std::make_shared<YamlNode>();
  node->kind = YamlNode::Kind::scalar;
  node->mark = mark_of(mark);
  require_no_tag(tag, node->mark);
  node->text = value;
  node->quoted = tag == "!";
  if (anchor != 0) anchors_[anchor] = node;
  add(node, node->mark);
}

void YamlBuilder::OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) {
  const auto found = anchors_.find(anchor);
  if (found == anchors_.end()) {
    fail(mark_of(mark), "an alias that refers to the section that contains it",
         "expected an alias of something complete");
  }
  add(found->second, mark_of(mark));
}

void YamlBuilder::OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                                  YAML::EmitterStyle::value) {
  open(YamlNode::Kind::sequence, mark, tag, anchor);
}
void YamlBuilder::OnSequenceEnd() {
  close();
}

void YamlBuilder::OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                             YAML::EmitterStyle::value) {
  open(YamlNode::Kind::map, mark, tag, anchor);
}
void YamlBuilder::OnMapEnd() {
  close();
}

void YamlBuilder::open(YamlNode::Kind kind, const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) {
  Open opened;
  opened.node = std::make_shared<YamlNode>();
  opened.node->kind = kind;
  opened.node->mark = mark_of(mark);
  opened.anchor = anchor;
  require_no_tag(tag, opened.node->mark);
  if (open_.size() >= static_cast<std::size_t>(YamlLimits::kMaxDepth)) {
    fail(opened.node->mark, "more than " + std::to_string(YamlLimits::kMaxDepth) + " levels of nesting",
         "expected the few levels of a scenario");
  }
  open_.push_back(std::move(opened));
}

void YamlBuilder::close() {
  Open closed = std::move(open_.back());
  open_.pop_back();
  merge(closed);
  YamlNode& node = *closed.node;
  for (const auto& item : node.items) node.height = std::max(node.height, item->height + 1);
  for (const auto& entry : node.entries) node.height = std::max(node.height, entry.value->height + 1);
  // Aliases of aliases can be deep although no line of the file is.
  if (node.height > YamlLimits::kMaxDepth) {
    fail(node.mark, "more than " + std::to_string(YamlLimits::kMaxDepth) + " levels of nesting through aliases",
         "expected the few levels of a scenario");
  }
  if (closed.anchor != 0) anchors_[closed.anchor] = closed.node;
  add(closed.node, node.mark);
}

void YamlBuilder::add(const YamlNodePtr& node, const YamlMark& mark) {
  count(1, mark);
  if (open_.empty()) {
    root_ = node;
  } else if (open_.back().node->kind == YamlNode::Kind::sequence) {
    open_.back().node->items.push_back(node);
  } else {
    add_to_map(open_.back(), node, mark);
  }
}

void YamlBuilder::add_to_map(Open& map, const YamlNodePtr& node, const YamlMark& mark) {
  if (map.has_key) {
    map.has_key = false;
    if (map.key == "<<") {
      map.merges.push_back(node);
    } else {
      YamlNodePtr value = node;
      if (node->kind == YamlNode::Kind::null) {
        // yaml-cpp puts a value that is left out where the next thing begins; the key is where the user has to look.
        auto nothing = std::make_shared<YamlNode>();
        nothing->mark = map.key_mark;
        value = nothing;
      }
      map.node->entries.push_back({std::move(map.key), map.key_mark, std::move(value)});
    }
    return;
  }
  if (node->kind != YamlNode::Kind::scalar) {
    fail(mark, "found " + shown(*node) + " instead of a key", "expected a key name");
  }
  map.key = node->text;
  map.key_mark = mark;
  map.has_key = true;
}

void YamlBuilder::merge(Open& map) {
  std::map<std::string_view, int> lines;
  for (const auto& entry : map.node->entries) {
    const auto [first, fresh] = lines.emplace(entry.key, entry.mark.line);
    if (!fresh) {
      fail(entry.mark, shown_key(entry.key) + ": duplicate key",
           "give it once; it is on line " + std::to_string(first->second) + " already");
    }
  }
  for (const auto& from : map.merges) {
    if (from->kind != YamlNode::Kind::sequence) {
      merge_one(*map.node, from);
      continue;
    }
    for (const auto& item : from->items) merge_one(*map.node, item);
  }
}

void YamlBuilder::merge_one(YamlNode& map, const YamlNodePtr& from) {
  if (from->kind != YamlNode::Kind::map) {
    fail(from->mark, "<<: found " + shown(*from), "expected an alias of a section of keys");
  }
  count(map.entries.size() + from->entries.size(), map.mark);
  std::set<std::string, std::less<>> names;
  for (const auto& entry : map.entries) names.insert(entry.key);
  for (const auto& entry : from->entries) {
    if (names.insert(entry.key).second) map.entries.push_back(entry);
  }
}

}  // namespace reamsim
