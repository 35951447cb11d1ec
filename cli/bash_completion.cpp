// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <CLI/CLI.hpp>

#include "cli/completion.h"
#include "cli/completion_kind.h"

namespace reamsim {

namespace {

constexpr const char* kHead = R"bash(# bash completion for reamsim; written by: reamsim help --format bash

# _reamsim_names KIND WORD: names of shipped scenarios or studies, which the program on the command line itself knows.
# A word with a slash is a path.
_reamsim_names()
{
    case $2 in */*) return ;; esac
    local program=${COMP_WORDS[0]/#\~\//$HOME/}
    COMPREPLY+=( $(compgen -W "$("$program" help --format "$1" 2>/dev/null)" -- "$2") )
}

# _reamsim_paths ENDING WORD: folders and files with this ending ("": all files; "/": folders only).
_reamsim_paths()
{
    local IFS=$'\n'
    compopt -o filenames 2>/dev/null
    COMPREPLY+=( $(compgen -d -- "$2") )
    [ "$1" = / ] || COMPREPLY+=( $(compgen -f -X "!*$1" -- "$2" | while read -r path; do
        [ -d "$path" ] || printf '%s\n' "$path"; done) )
}

_reamsim_words() { COMPREPLY+=( $(compgen -W "$1" -- "$2") ); }

_reamsim()
{
    local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} command= i
    COMPREPLY=()
    for ((i = 1; i < COMP_CWORD; i++)); do
        case "$command/${COMP_WORDS[i]}" in
)bash";

std::string words_of(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : " ") + word;
  return out;
}

/// "a|b", in quotes, with `before` before each.
std::string pattern_of(const std::string& before, const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "\"" : "|\"") + before + word + "\"";
  return out;
}

std::vector<std::string> names_below(const CLI::App& app) {
  std::vector<std::string> out;
  for (const ListedCommand& command : listed_commands(app)) {
    if (command.name.find(' ') == std::string::npos) out.push_back(command.name);
  }
  return out;
}

/// What completes the present word; "" where nothing can.
std::string action_of(const ArgumentText& argument, const CLI::App& root) {
  const auto words = [](const std::string& list) { return "_reamsim_words \"" + list + "\" \"$current\""; };
  const auto names = [](const std::string& kind) { return "_reamsim_names " + kind + " \"$current\"; "; };
  switch (completed_by(argument)) {
    case Completed::choices:
      return words(words_of(argument.choices));
    case Completed::commands:
      return words(words_of(names_below(root)));
    case Completed::scenarios:
      return names("scenarios") + "_reamsim_paths .yaml \"$current\"; _reamsim_paths .yml \"$current\"";
    case Completed::studies:
      return names("studies") + "_reamsim_paths .yaml \"$current\"";
    case Completed::folders:
      return "_reamsim_paths / \"$current\"";
    case Completed::files:
      return "_reamsim_paths \"\" \"$current\"";
    case Completed::files_and_scenarios:
      return names("scenarios") + "_reamsim_paths \"\" \"$current\"";
    case Completed::nothing:
      break;
  }
  return "";
}

/// Cases of the values of options.
std::string value_cases(const ListedCommand& command, const CLI::App& root) {
  std::string out;
  for (const ArgumentText& option : options_of(*command.app)) {
    if (option.value.empty()) continue;
    const std::string action = action_of(option, root);
    out += "        " + pattern_of(command.name + " ", option.flags) + ") " + (action.empty() ? ":" : action) +
           "; return ;;\n";
  }
  return out;
}

/// The case of a command's own words: options, commands below it, and its first argument.
std::string command_case(const ListedCommand& command, const CLI::App& root) {
  std::vector<std::string> flags;
  for (const ArgumentText& option : options_of(*command.app)) {
    flags.insert(flags.end(), option.flags.begin(), option.flags.end());
  }
  std::string out = "        \"" + command.name +
                    "\")\n            case \"$current\" in\n                -*) _reamsim_words \"" + words_of(flags) +
                    "\" \"$current\"; return ;;\n            esac\n";
  const std::vector<std::string> below = names_below(*command.app);
  if (!below.empty()) out += "            _reamsim_words \"" + words_of(below) + "\" \"$current\"\n";
  const std::vector<ArgumentText> positionals = positionals_of(*command.app);
  std::string actions;
  for (const ArgumentText& positional : positionals) {
    const std::string action = action_of(positional, root);
    if (!action.empty()) actions = "            " + action + "\n";  // the last: files after folders
  }
  return out + actions + "            ;;\n";
}

}  // namespace

std::string bash_completion(const CLI::App& root) {
  std::vector<ListedCommand> commands = listed_commands(root);
  std::vector<std::string> known;
  for (const ListedCommand& command : commands) {
    const std::size_t space = command.name.find(' ');
    known.push_back(space == std::string::npos ? "/" + command.name
                                               : command.name.substr(0, space) + "/" + command.name.substr(space + 1));
  }
  commands.insert(commands.begin(), {"", &root});
  std::string out = kHead;
  out += "            " + pattern_of("", known) + ") command=\"${command:+$command }${COMP_WORDS[i]}\" ;;\n";
  out += "        esac\n    done\n    case \"$command $previous\" in\n";
  for (const ListedCommand& command : commands) out += value_cases(command, root);
  out += "    esac\n    case \"$command\" in\n";
  for (const ListedCommand& command : commands) out += command_case(command, root);
  return out + "    esac\n}\n\ncomplete -F _reamsim reamsim\n";
}

}  // namespace reamsim
