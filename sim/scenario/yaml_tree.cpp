// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/yaml_tree.h"

#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <yaml-cpp/emitterstyle.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/mark.h>
#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

#include "sim/base/text.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

/// Begins of the lines of a text, to convert yaml-cpp's marks (from 0, columns in bytes).
class LineIndex {
 public:
  explicit LineIndex(std::string_view text) : text_(text) {
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] == '\n') starts_.push_back(i + 1);
    }
  }
  [[nodiscard]] YamlMark mark(int line, int byte_column) const {
    if (line < 0 || byte_column < 0) return {};
    const std::size_t start = starts_[std::min(static_cast<std::size_t>(line), starts_.size() - 1)];
    const std::string_view before = text_.substr(start, static_cast<std::size_t>(byte_column));
    const auto characters = std::ranges::count_if(before, [](char c) { return (c & 0xC0) != 0x80; });
    return {line + 1, static_cast<int>(characters) + 1, nullptr};
  }
  /// Of a byte of the text.
  [[nodiscard]] YamlMark mark_of(std::size_t byte) const {
    const auto line = std::ranges::upper_bound(starts_, byte) - starts_.begin() - 1;
    return mark(static_cast<int>(line), static_cast<int>(byte - starts_[static_cast<std::size_t>(line)]));
  }
  /// The first tab in the indentation of a line (from 0); line 0 of the mark when there is none.
  [[nodiscard]] YamlMark tab_in_indentation(int line) const {
    if (line < 0 || static_cast<std::size_t>(line) >= starts_.size()) return {};
    const std::size_t start = starts_[static_cast<std::size_t>(line)];
    const std::size_t tab = text_.find_first_not_of(' ', start);
    const bool found = tab != std::string_view::npos && text_[tab] == '\t';
    return found ? mark(line, static_cast<int>(tab - start)) : YamlMark{};
  }

 private:
  std::string_view text_;
  std::vector<std::size_t> starts_{0};
};

/// Unlike yaml-cpp's own tree, it reports duplicate keys, recursive aliases and the size after merging.
class YamlBuilder : public YAML::EventHandler {
 public:
  YamlBuilder(const LineIndex& lines, std::string file) : lines_(lines), file_(std::move(file)) {}

  [[nodiscard]] YamlNodePtr root() const { return root_; }
  /// Begin of the innermost open list or section; line 0 where none is open.
  [[nodiscard]] YamlMark open_mark() const { return open_.empty() ? YamlMark{} : open_.back().node->mark; }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ > 1) fail(mark_of(mark), "a second YAML document begins here", "expected one document per file");
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    add_named(std::make_shared<YamlNode>(YamlNode{.mark = mark_of(mark)}), anchor);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto found = anchors_.find(anchor);
    if (found == anchors_.end()) {
      fail(mark_of(mark), "an alias that refers to the section that contains it",
           "expected an alias of something complete");
    }
    add(found->second, mark_of(mark));
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    const YamlNodePtr node = std::make_shared<YamlNode>(
        YamlNode{.kind = YamlNode::Kind::scalar, .mark = mark_of(mark), .text = value, .quoted = tag == "!"});
    require_no_tag(tag, node->mark);
    add_named(node, anchor);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(YamlNode::Kind::sequence, mark, tag, anchor);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(YamlNode::Kind::map, mark, tag, anchor);
  }
  void OnMapEnd() override { close(); }

 private:
  /// An open list or section.
  struct Open {
    std::shared_ptr<YamlNode> node;
    YAML::anchor_t anchor = 0;
    std::optional<std::string> key{};  // a map's key without its value yet
    YamlMark key_mark{};
    std::vector<YamlNodePtr> merges{};  // values of "<<"
  };

  void open(YamlNode::Kind kind, const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) {
    const Open opened{std::make_shared<YamlNode>(YamlNode{.kind = kind, .mark = mark_of(mark)}), anchor};
    require_no_tag(tag, opened.node->mark);
    if (open_.size() >= static_cast<std::size_t>(YamlLimits::kMaxDepth)) {
      fail(opened.node->mark, "more than " + std::to_string(YamlLimits::kMaxDepth) + " levels of nesting",
           "expected the few levels of a scenario");
    }
    open_.push_back(opened);
  }
  void close() {
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
    add_named(closed.node, closed.anchor);
  }
  void add_named(const YamlNodePtr& node, YAML::anchor_t anchor) {
    if (anchor != 0) anchors_[anchor] = node;
    add(node, node->mark);
  }
  void add(const YamlNodePtr& node, const YamlMark& mark) {
    count(1, mark);
    if (open_.empty()) {
      root_ = node;
    } else if (open_.back().node->kind == YamlNode::Kind::sequence) {
      open_.back().node->items.push_back(node);
    } else {
      add_to_map(open_.back(), node, mark);
    }
  }
  void add_to_map(Open& map, const YamlNodePtr& node, const YamlMark& mark) {
    if (!map.key) {
      if (node->kind != YamlNode::Kind::scalar)
        fail(mark, "found " + shown(*node) + " instead of a key", "expected a key name");
      map.key = node->text;
      map.key_mark = mark;
      return;
    }
    const std::string key = *std::exchange(map.key, std::nullopt);
    if (key == "<<") return map.merges.push_back(node);
    // yaml-cpp puts a value that is left out where the next thing begins; the key is where the user has to look.
    const bool nothing = node->kind == YamlNode::Kind::null;
    map.node->entries.push_back(
        {key, map.key_mark, nothing ? std::make_shared<YamlNode>(YamlNode{.mark = map.key_mark}) : node});
  }
  void merge(Open& map) {
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
  void merge_one(YamlNode& map, const YamlNodePtr& from) {
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
  void count(std::size_t nodes, const YamlMark& mark) {
    nodes_ += nodes;
    if (nodes_ > YamlLimits::kMaxNodes) {
      fail(mark, "more than " + std::to_string(YamlLimits::kMaxNodes) + " values",
           "reduce the file (put long recordings into motion.csv)");
    }
  }
  void require_no_tag(const std::string& tag, const YamlMark& mark) const {
    if (tag.empty() || tag == "?" || tag == "!") return;
    fail(mark, "found the YAML tag " + shown_text(tag), "expected a value without a tag");
  }
  [[nodiscard]] YamlMark mark_of(const YAML::Mark& mark) const { return lines_.mark(mark.line, mark.column); }
  [[noreturn]] void fail(const YamlMark& mark, const std::string& found, const std::string& expected) const {
    throw InputError(mark.in(file_), "", found, expected);
  }

  const LineIndex& lines_;
  std::string file_;
  std::vector<Open> open_;
  std::map<YAML::anchor_t, YamlNodePtr> anchors_;
  YamlNodePtr root_;
  std::size_t nodes_ = 0;
  int documents_ = 0;
};

/// Our words for what yaml-cpp may complain of: (how its message begins, found, expected).
struct Rephrased {
  std::string_view theirs;
  const char* found;
  const char* expected;
};

constexpr Rephrased kRephrased[]{
    {"end of map not found", "a line that does not continue the section above it",
     "expected \"key: value\" with the same indentation as its neighbours"},
    {"end of map flow not found", "a \"{\" that is not closed", "expected \"}\""},
    {"end of sequence not found", "a line that does not continue the list above it",
     "expected \"- value\" with the same indentation as its neighbours"},
    {"end of sequence flow not found", "a \"[\" that is not closed", "expected \"]\""},
    {"illegal EOF in scalar", "a quotation mark that is not closed", "close it before the end"},
    {"illegal document indicator in scalar", "a quotation mark that is not closed",
     "close it before the end of the document"},
    {"illegal map value", "a \":\" where no key can be",
     "expected one \"key: value\" per line, with even indentation, and texts that hold \": \" in quotes"},
    {"illegal map key", "a key where none can be", "expected one \"key: value\" per line"},
    {"illegal block entry", "a \"-\" where no list entry can be",
     "expected it on a line of its own, indented with spaces"},
    {"illegal flow end", "a \"]\" or \"}\" that closes nothing", "expected the bracket that opens it"},
    {"unknown escape character", "an unknown escape after \"\\\" in a quoted text",
     "expected \\\\ for a backslash, or single quotes"},
    {"bad character found while scanning hex number", "a \\x, \\u or \\U without its hex digits",
     "expected 2, 4 or 8 hex digits"},
    {"invalid unicode", "a \\u or \\U that is no Unicode character", "expected a Unicode code point"},
    {"the referenced anchor is not defined", "an alias (*name) without its anchor",
     "expected the anchor (&name) before it"},
    {"alias not found", "a \"*\" without a name", "expected an alias name, or the text in quotes"},
    {"anchor not found", "a \"&\" without a name", "expected an anchor name, or the text in quotes"},
    {"unknown token", "a character that cannot begin a value", "expected the text in quotes"},
};

[[noreturn]] void throw_syntax_error(const YAML::Exception& error, const LineIndex& lines, const YamlBuilder& builder,
                                     const std::string& file) {
  const YamlMark tab = lines.tab_in_indentation(error.mark.line);
  if (tab.line > 0) {
    throw InputError(tab.in(file), "", "YAML syntax error: a tab in the indentation", "expected spaces");
  }
  const std::string_view theirs = error.msg;
  YamlMark mark = lines.mark(error.mark.line, error.mark.column);
  const auto match = std::ranges::find_if(kRephrased, [&](const auto& r) { return theirs.starts_with(r.theirs); });
  if (match == std::end(kRephrased)) {
    throw InputError(mark.in(file), "", "YAML syntax error", "expected \"key: value\" lines in valid YAML");
  }
  // yaml-cpp reports a bracket that is never closed at the end of the file; where it was opened helps more.
  const bool unclosed = theirs.find("flow not found") != std::string_view::npos;
  if (unclosed && builder.open_mark().line > 0) mark = builder.open_mark();
  throw InputError(mark.in(file), "", std::string("YAML syntax error: ") + match->found, match->expected);
}

void require_text(std::string_view text, const LineIndex& lines, const std::string& file) {
  for (std::size_t i = 0, length = 0; i < text.size(); i += length) {
    length = utf8_length(text, i);
    const auto byte = static_cast<unsigned char>(text[i]);
    const bool control = (byte < 0x20 && byte != '\n' && byte != '\r' && byte != '\t') || byte == 0x7f;
    if (length > 0 && !control) continue;
    throw InputError(lines.mark_of(i).in(file), "",
                     "found the byte " + shown_text(text.substr(i, 1)) + ": not a text file", "expected YAML in UTF-8");
  }
}

}  // namespace

SourceLocation YamlMark::in(const std::string& file) const {
  if (override_text) return {*override_text, 0, 0};
  return {file, line, column};
}

const YamlEntry* YamlNode::find(std::string_view key) const {
  const auto found = std::ranges::find(entries, key, &YamlEntry::key);
  return found == entries.end() ? nullptr : &*found;
}

const YamlNode* YamlNode::at(std::string_view path) const {
  const YamlNode* node = this;
  for (const std::string& step : split(path, '.')) {
    const std::optional<std::uint64_t> index = whole_number(step);
    const YamlEntry* entry = node->find(step);
    const bool item = node->kind == Kind::sequence && index && *index < node->items.size();
    node = item ? node->items[*index].get() : entry == nullptr ? nullptr : entry->value.get();
    if (node == nullptr) break;
  }
  return node;
}

YamlNodePtr parse_yaml(std::string_view text, const std::string& file) {
  if (text.size() > YamlLimits::kMaxBytes) {
    refuse_file(file, "larger than " + std::to_string(YamlLimits::kMaxBytes >> 20) + " MiB",
                "expected a scenario (put long recordings into motion.csv)");
  }
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // the byte order mark that some editors write
  const LineIndex lines(text);
  require_text(text, lines, file);
  YamlBuilder builder(lines, file);
  std::istringstream stream{std::string(text)};
  try {
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(builder)) {
    }
  } catch (const YAML::Exception& error) {
    throw_syntax_error(error, lines, builder, file);
  }
  return builder.root() ? builder.root() : std::make_shared<YamlNode>();
}

}  // namespace reamsim
