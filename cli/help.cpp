// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <span>

#include "cli/command_line.h"
#include "cli/commands.h"
#include "cli/manual.h"
#include "sim/base/error.h"
#include "sim/scenario/shipped.h"

namespace reamsim {

namespace {

struct HelpOptions {
  std::vector<std::string> words;
  std::string format = "text";
};

/// The command that the words name, such as "sweep run". Throws InputError.
ListedCommand named_command(const CLI::App& root, const std::vector<std::string>& words) {
  std::string name;
  for (const std::string& word : words) name += (name.empty() ? "" : " ") + word;
  if (name.empty()) return {"", &root};
  const std::vector<ListedCommand> commands = listed_commands(root);
  const auto found = std::ranges::find(commands, name, &ListedCommand::name);
  if (found != commands.end()) return *found;
  throw InputError({}, "", name + ": unknown command", "expected " + command_names(root));
}

std::string lines_of(const std::vector<std::string>& names) {
  std::string out;
  for (const std::string& name : names) out += name + "\n";
  return out;
}

std::string text_of(const CLI::App& root, const HelpOptions& options) {
  if (options.format != "text" && !options.words.empty()) {
    throw InputError({}, "--format", options.format + " is of the whole program", "leave the command out");
  }
  if (options.format == "man") return man_page(root);
  if (options.format == "bash") return bash_completion(root);
  if (options.format == "zsh") return zsh_completion(root);
  if (options.format == "scenarios") return lines_of(shipped_names(ShippedKind::scenario));
  if (options.format == "studies") return lines_of(shipped_names(ShippedKind::study));
  return help_of(named_command(root, options.words));
}

}  // namespace

void add_help_command(CLI::App& app) {
  auto* command = app.add_subcommand("help", "Print the help of reamsim or of a command");
  auto options = std::make_shared<HelpOptions>();
  command->add_option("COMMAND", options->words, "A command, for example run, or sweep run");
  command
      ->add_option("--format", options->format,
                   "text, or of the whole program: man page, completion for bash, completion for zsh, names of shipped "
                   "scenarios, names of shipped studies")
      ->check(CLI::IsMember({"text", "man", "bash", "zsh", "scenarios", "studies"}));
  command->callback([options, &app] { std::fputs(text_of(app, *options).c_str(), stdout); });
}

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
