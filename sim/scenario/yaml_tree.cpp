// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/yaml_tree.h"

#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <array>
#include <sstream>
#include <utility>

#include "sim/base/printable.h"
#include "sim/scenario/show.h"
#include "sim/scenario/yaml_builder.h"

namespace reamsim {

SourceLocation YamlMark::in(const std::string& file) const {
  if (override_text) return {*override_text, 0, 0};
  return {file, line, column};
}

const YamlEntry* YamlNode::find(std::string_view key) const {
  const auto found = std::ranges::find(entries, key, &YamlEntry::key);
  return found == entries.end() ? nullptr : &*found;
}

namespace {

/// Our words for what yaml-cpp may complain of: (how its message begins, found, expected).
struct Rephrased {
  std::string_view theirs;
  const char* found;
  const char* expected;
};

constexpr std::array kRephrased{
    Rephrased{"end of map not found", "a line that does not continue the section above it",
              "expected \"key: value\" with the same indentation as its neighbours"},
    Rephrased{"end of map flow not found", "a \"{\" that is not closed", "expected \"}\""},
    Rephrased{"end of sequence not found", "a line that does not continue the list above it",
              "expected \"- value\" with the same indentation as its neighbours"},
    Rephrased{"end of sequence flow not found", "a \"[\" that is not closed", "expected \"]\""},
    Rephrased{"illegal EOF in scalar", "a quotation mark that is not closed", "close it before the end"},
    Rephrased{"illegal document indicator in scalar", "a quotation mark that is not closed",
              "close it before the end of the document"},
    Rephrased{"illegal map value", "a \":\" where no key can be",
              "expected one \"key: value\" per line, with even indentation, and texts that hold \": \" in quotes"},
    Rephrased{"illegal map key", "a key where none can be", "expected one \"key: value\" per line"},
    Rephrased{"illegal block entry", "a \"-\" where no list entry can be",
              "expected it on a line of its own, indented with spaces"},
    Rephrased{"illegal flow end", "a \"]\" or \"}\" that closes nothing", "expected the bracket that opens it"},
    Rephrased{"unknown escape character", "an unknown escape after \"\\\" in a quoted text",
              "expected \\\\ for a backslash, or single quotes"},
    Rephrased{"bad character found while scanning hex number", "a \\x, \\u or \\U without its hex digits",
              "expected 2, 4 or 8 hex digits"},
    Rephrased{"invalid unicode", "a \\u or \\U that is no Unicode character", "expected a Unicode code point"},
    Rephrased{"the referenced anchor is not defined", "an alias (*name) without its anchor",
              "expected the anchor (&name) before it"},
    Rephrased{"alias not found", "a \"*\" without a name", "expected an alias name, or the text in quotes"},
    Rephrased{"anchor not found", "a \"&\" without a name", "expected an anchor name, or the text in quotes"},
    Rephrased{"unknown token", "a character that cannot begin a value", "expected the text in quotes"},
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
  if (match == kRephrased.end()) {
    throw InputError(mark.in(file), "", "YAML syntax error", "expected \"key: value\" lines in valid YAML");
  }
  // yaml-cpp reports a bracket that is never closed at the end of the file; where it was opened helps more.
  const bool unclosed = theirs.find("flow not found") != std::string_view::npos;
  if (unclosed && builder.open_mark().line > 0) mark = builder.open_mark();
  throw InputError(mark.in(file), "", std::string("YAML syntax error: ") + match->found, match->expected);
}

void require_text(std::string_view text, const LineIndex& lines, const std::string& file) {
  int line = 0;
  std::size_t line_start = 0;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = utf8_length(text, i);
    const auto byte = static_cast<unsigned char>(text[i]);
    const bool control = (byte < 0x20 && byte != '\n' && byte != '\r' && byte != '\t') || byte == 0x7f;
    if (length == 0 || control) {
      const std::string shown_byte = shown_text(text.substr(i, 1));
      throw InputError(lines.mark(line, static_cast<int>(i - line_start)).in(file), "",
                       "found the byte " + shown_byte + ": not a text file", "expected YAML in UTF-8");
    }
    i += length;
    if (byte == '\n') {
      ++line;
      line_start = i;
    }
  }
}

}  // namespace

YamlNodePtr parse_yaml(std::string_view text, const std::string& file) {
  if (text.size() > YamlLimits::kMaxBytes) {
    throw InputError({file, 0, 0}, "", "larger than " + std::to_string(YamlLimits::kMaxBytes >> 20) + " MiB",
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
