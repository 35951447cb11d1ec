// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/scenario/choices.h"
#include "sim/scenario/paths.h"

namespace CLI {
class App;
}  // namespace CLI

namespace reamsim {

// What the commands and their options say of themselves. Help, man page and completion are made from it.

inline constexpr std::string_view kDescription =
    "reamsim simulates glenoid reaming: it turns a scenario into cutting forces, pictures and an OpenVDB grid.";

/// A term and what it means.
struct Entry {
  std::string_view term;
  std::string_view meaning;
};

/// A command that users may call: "sweep run" and its parser.
struct ListedCommand {
  std::string name;
  const CLI::App* app;
};

/// The commands directly below `app`.
std::vector<const CLI::App*> commands_below(const CLI::App& app);

/// The commands of `root` in the order of its help, each followed by its own.
std::vector<ListedCommand> listed_commands(const CLI::App& root);

/// "run, check, ... or devices": the commands directly below `root`.
std::string command_names(const CLI::App& root);

/// What an option or argument of a command takes.
struct ArgumentText {
  std::vector<std::string> flags;  ///< "-o", "--output"; of an argument by position none
  std::string value;               ///< "DIR"; of a flag ""
  std::vector<std::string> choices;
  std::string description;
  bool required = false;
  bool repeats = false;
};

/// The options of a command, also those of its groups.
std::vector<ArgumentText> options_of(const CLI::App& command);
/// Its arguments by position.
std::vector<ArgumentText> positionals_of(const CLI::App& command);

/// "reamsim sweep run [OPTIONS] STUDY", and a note of the subcommand that is needed.
std::string synopsis_of(const ListedCommand& command);
/// The exit statuses of a command; of the program where `name` is "".
std::vector<Entry> exit_statuses_of(const std::string& name);
/// What `reamsim COMMAND --help` prints; of the program where `command.name` is "".
std::string help_of(const ListedCommand& command);
/// Makes help_of() the help of `app`, and of commands that are added to it.
void set_help(CLI::App& app);

/// The extension of a file name in small letters, with its dot: ".yaml"; "" without one.
std::string lower_extension(const std::string& path);

/// The source of a bone by the content of its file: vdb, mesh or ct; by the ending of its name where the content says
/// nothing. Meshes in formats that are not read count as meshes, which gives a helpful error message.
BoneSource source_of_file(const std::string& path);

/// Adds `--set KEY.PATH=VALUE`, repeatable. `what`: what it does, with an example.
void add_overrides(CLI::App& command, std::vector<std::string>& overrides, const std::string& what);

/// For CLI11's transform(): shipped_or_path().
template <ShippedKind kind>
std::string shipped(const std::string& argument) {
  return shipped_or_path(argument, kind);
}

}  // namespace reamsim
