// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>

#include "cli/command_line.h"
#include "cli/commands.h"
#include "cli/completion.h"
#include "cli/man_page.h"
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

}  // namespace reamsim
