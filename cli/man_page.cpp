// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/man_page.h"

#include <CLI/CLI.hpp>
#include <span>

#include "cli/command_line.h"
#include "cli/manual_text.h"

namespace reamsim {

namespace {

/// Text that roff prints as it is.
std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else if (c == '\'') {
      out += "\\(aq";
    } else if (c == '`') {
      out += "\\(ga";
    } else if (c == '^') {
      out += "\\(ha";
    } else if (c == '~') {
      out += "\\(ti";
    } else {
      out += c;
    }
  }
  return out;
}

/// A line of text. A period at its start would be a request.
std::string line(std::string_view text) {
  return (text.starts_with('.') ? "\\&" : "") + escaped(text) + "\n";
}

std::string bold(std::string_view text) {
  return "\\fB" + escaped(text) + "\\fR";
}

std::string italic(std::string_view text) {
  return "\\fI" + escaped(text) + "\\fR";
}

std::string section(std::string_view title) {
  return ".SH " + std::string(title) + "\n";
}

std::string entries(std::span<const Entry> list) {
  std::string out;
  for (const Entry& entry : list) out += ".TP\n" + bold(entry.term) + "\n" + line(entry.meaning);
  return out;
}

std::string term_of(const ArgumentText& argument) {
  std::string out;
  for (const std::string& flag : argument.flags) out += (out.empty() ? "" : ", ") + bold(flag);
  if (!argument.value.empty()) out += (out.empty() ? "" : " ") + italic(argument.value);
  return out + (argument.repeats ? "..." : "");
}

std::string arguments(const std::vector<ArgumentText>& list) {
  std::string out;
  for (const ArgumentText& argument : list) {
    out += ".TP\n" + term_of(argument) + "\n";
    out += line(argument.description + (argument.required && !argument.flags.empty() ? " (required)" : ""));
  }
  return out;
}

std::string command_section(const ListedCommand& command) {
  std::string out = ".SS \"" + escaped(synopsis_of(command)) + "\"\n";
  out += line(command.app->get_description());
  return out + arguments(positionals_of(*command.app)) + arguments(options_of(*command.app));
}

}  // namespace

std::string man_page(const CLI::App& root) {
  std::string out = ".TH REAMSIM 1 \"\" \"reamsim " REAMSIM_VERSION "\" \"User Commands\"\n";
  out += section("NAME") + "reamsim \\- " + escaped(kSummary) + "\n";
  out += section("SYNOPSIS") + bold("reamsim") + " " + italic("COMMAND") + " [" + italic("OPTIONS") + "]\n";
  out += section("DESCRIPTION") + line(kDescription);
  out += ".PP\n" + line(
                       "A scenario is one YAML file: bone, reamer and motion. In the documentation of the package, "
                       "keys.md has its keys and results.md the files of a run.");
  out += section("OPTIONS") + arguments(options_of(root));
  out += section("COMMANDS");
  for (const ListedCommand& command : listed_commands(root)) out += command_section(command);
  out += section("\"EXIT STATUS\"") + entries(kExitStatuses);
  out += section("ENVIRONMENT") + entries(kVariables);
  out += section("EXAMPLES") + entries(kExamples);
  out += section("\"SEE ALSO\"") + ".BR gnuplot (1),\n.BR ffmpeg (1),\n.BR clinfo (1)\n";
  return out;
}

}  // namespace reamsim
