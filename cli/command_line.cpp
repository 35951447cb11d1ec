// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "cli/manual_text.h"
#include "sim/base/text.h"

namespace reamsim {

namespace {

/// Visits `app` and the groups of options that belong to it, which CLI11 keeps as nameless commands.
template <class Visit>
void for_each_group(const CLI::App& app, const Visit& visit) {
  visit(app);
  for (const CLI::App* below : app.get_subcommands([](const CLI::App* sub) { return sub->get_name().empty(); })) {
    for_each_group(*below, visit);
  }
}

/// CLI11 writes the type as "TEXT:{law,classes}" or "INT:INT in [1 - 9]"; this program also as "osmesa|egl".
void set_value(const std::string& type, ArgumentText& out) {
  const std::size_t brace = type.find(":{");
  if (brace != std::string::npos) {
    out.choices = split(type.substr(brace + 2, type.size() - brace - 3), ',');
  } else if (type.find('|') != std::string::npos) {
    out.choices = split(type, '|');
  }
  out.value = type.substr(0, type.find(':'));
  if (type.find(':') != std::string::npos && brace == std::string::npos && !type.starts_with("INT") &&
      !type.starts_with("FLOAT")) {
    out.value = type;  // HH:MM:SS
  }
  if (out.choices.empty()) return;
  out.value.clear();
  for (const std::string& choice : out.choices) out.value += (out.value.empty() ? "" : "|") + choice;
}

ArgumentText text_of(const CLI::Option& option) {
  ArgumentText out;
  for (const std::string& name : option.get_snames()) out.flags.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) out.flags.push_back("--" + name);
  // A flag such as --film takes a value only after "=".
  if (option.get_expected_min() > 0) set_value(option.get_type_name(), out);
  if (option.get_positional()) out.value = option.get_name(true, false);
  out.description = option.get_description();
  out.required = option.get_required();
  out.repeats = option.get_expected_max() >= CLI::detail::expected_max_vector_size ||
                option.get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
  return out;
}

void add_commands_below(const CLI::App& app, const std::string& path, std::vector<ListedCommand>& out) {
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App* s) { return !s->get_group().empty(); })) {
    if (sub->get_name().empty()) continue;
    const std::string name = path + sub->get_name();
    out.push_back({name, sub});
    add_commands_below(*sub, name + " ", out);
  }
}

/// The exit statuses of a command; of the program where `name` is "".
std::vector<Entry> exit_statuses_of(const std::string& name) {
  std::vector<Entry> out(kExitStatuses.begin(), kExitStatuses.end());
  if (name.empty()) return out;
  const auto suspended = std::ranges::find(out, kSuspended, &Entry::term);
  const auto own = std::ranges::find(kSuspendable, name, &Entry::term);
  if (own == kSuspendable.end()) {
    out.erase(suspended);
  } else {
    suspended->meaning = own->meaning;
  }
  return out;
}

std::string footer_of(const std::string& name) {
  std::string out = "Exit status:\n";
  for (const Entry& status : exit_statuses_of(name)) {
    out += "  " + std::string(status.term) + std::string(28 - status.term.size(), ' ') + std::string(status.meaning) +
           "\n";
  }
  return out + "\nreamsim help COMMAND prints the options of a command, reamsim help --format man the man page.";
}

}  // namespace

std::vector<ListedCommand> listed_commands(const CLI::App& root) {
  std::vector<ListedCommand> out;
  add_commands_below(root, "", out);
  return out;
}

std::string command_names(const CLI::App& root) {
  std::vector<std::string> names;
  for (const ListedCommand& command : listed_commands(root)) {
    if (command.name.find(' ') == std::string::npos) names.push_back(command.name);
  }
  std::string out;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) out += i + 1 == names.size() ? " or " : ", ";
    out += names[i];
  }
  return out;
}

std::vector<ArgumentText> options_of(const CLI::App& command) {
  std::vector<ArgumentText> out;
  for_each_group(command, [&](const CLI::App& group) {
    for (const CLI::Option* option : group.get_options()) {
      if (option->nonpositional() && !option->get_group().empty()) out.push_back(text_of(*option));
    }
  });
  return out;
}

std::vector<ArgumentText> positionals_of(const CLI::App& command) {
  std::vector<ArgumentText> out;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_positional()) out.push_back(text_of(*option));
  }
  return out;
}

std::string synopsis_of(const ListedCommand& command) {
  std::string out = "reamsim" + (command.name.empty() ? "" : " " + command.name) + " [OPTIONS]";
  for (const ArgumentText& argument : positionals_of(*command.app)) {
    const std::string value = argument.value + (argument.repeats ? "..." : "");
    out += argument.required ? " " + value : " [" + value + "]";
  }
  if (command.app->get_require_subcommand_min() > 0) out += " COMMAND";
  return out;
}

std::string help_of(const ListedCommand& command) {
  const std::string name = "reamsim" + (command.name.empty() ? "" : " " + command.name);
  return command.app->get_formatter()->make_help(command.app, name, CLI::AppFormatMode::Normal);
}

void add_footers(CLI::App& app, const std::string& name) {
  app.footer(footer_of(name));
  for (CLI::App* below : app.get_subcommands([](const CLI::App* sub) { return !sub->get_name().empty(); })) {
    add_footers(*below, name.empty() ? below->get_name() : name + " " + below->get_name());
  }
}

}  // namespace reamsim
