// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <CLI/CLI.hpp>
#include <algorithm>

#include "cli/manual.h"

namespace reamsim {

namespace {

constexpr const char* kZshHead = R"zsh(#compdef reamsim
# zsh completion for reamsim; written by: reamsim help --format zsh

# _reamsim_names [OPTIONS OF compadd] KIND: names of shipped scenarios or studies, from the program on the command line.
_reamsim_names() {
  local kind=${@[-1]}
  local -a names
  names=(${(f)"$(_call_program $kind $_reamsim_program help --format $kind 2>/dev/null)"})
  compadd "${@[1,-2]}" -a names
}

_reamsim_scenarios() { _alternative 'names:shipped scenario:_reamsim_names scenarios' 'files:file:_files -g "*.y(|a)ml"' }
_reamsim_studies() { _alternative 'names:shipped study:_reamsim_names studies' 'files:file:_files -g "*.y(|a)ml"' }
_reamsim_inputs() { _alternative 'names:shipped scenario:_reamsim_names scenarios' 'files:file:_files' }

)zsh";

/// Text within single quotes, where zsh's _arguments gives [, ] and : a meaning.
std::string zsh_quoted(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\'') {
      out += "'\\''";
    } else if (c == '[' || c == ']' || c == ':' || c == '\\') {
      out += std::string("\\") + c;
    } else {
      out += c;
    }
  }
  return out;
}

std::string action_of(const ArgumentText& argument) {
  std::string words;
  for (const std::string& choice : argument.choices) words += (words.empty() ? "" : " ") + choice;
  switch (completed_by(argument)) {
    case Completed::choices:
      return "(" + words + ")";
    case Completed::commands:
      return "_reamsim_commands";
    case Completed::scenarios:
      return "_reamsim_scenarios";
    case Completed::studies:
      return "_reamsim_studies";
    case Completed::folders:
      return "_files -/";
    case Completed::files:
      return "_files";
    case Completed::files_and_scenarios:
      return "_reamsim_inputs";
    case Completed::nothing:
      break;
  }
  return " ";
}

/// '(-o --output)'{-o,--output}'[...]:DIR:_files -/' for each option.
std::string spec_of(const ArgumentText& option) {
  std::string all, braces;
  for (const std::string& flag : option.flags) {
    all += (all.empty() ? "" : " ") + flag;
    braces += (braces.empty() ? "" : ",") + flag + (option.value.empty() ? "" : flag.starts_with("--") ? "=" : "+");
  }
  const std::string names = option.flags.size() > 1 ? "'{" + braces + "}'" : braces;
  const std::string first = option.repeats ? "*" : "(" + all + ")";
  const std::string value = option.value.empty() ? "" : ":" + zsh_quoted(option.value) + ":" + action_of(option);
  return "    '" + first + names + "[" + zsh_quoted(option.description) + "]" + value + "'";
}

std::string options_text(const CLI::App& app) {
  std::string out;
  for (const ArgumentText& option : options_of(app)) out += " \\\n" + spec_of(option);
  return out;
}

std::string function_name(const std::string& path) {
  std::string out = path.empty() ? "_reamsim" : "_reamsim_" + path;
  std::ranges::replace(out, ' ', '_');
  return out;
}

/// The function of a command that takes arguments.
std::string leaf(const ListedCommand& command) {
  std::string out = function_name(command.name) + "() {\n  _arguments" + options_text(*command.app);
  for (const ArgumentText& argument : positionals_of(*command.app)) {
    out += std::string(" \\\n    '") + (argument.repeats ? "*" : "") + ":" + zsh_quoted(argument.value) + ":" +
           action_of(argument) + "'";
  }
  return out + "\n}\n\n";
}

/// The function of a command that has commands.
std::string branch(const ListedCommand& command) {
  std::string list, cases;
  for (const ListedCommand& below : listed_commands(*command.app)) {
    if (below.name.find(' ') != std::string::npos) continue;
    list += "    '" + below.name + ":" + zsh_quoted(below.app->get_description()) + "'\n";
    const std::string path = command.name.empty() ? below.name : command.name + " " + below.name;
    cases += "        " + below.name + ") " + function_name(path) + " ;;\n";
  }
  const std::string name = function_name(command.name);
  return name + "_commands() {\n  local -a commands\n  commands=(\n" + list +
         "  )\n  _describe -t commands command commands\n}\n\n" + name +
         "() {\n  local curcontext=$curcontext state line" +
         (command.name.empty() ? " _reamsim_program=$words[1]" : "") + "\n" + "  typeset -A opt_args\n  _arguments -C" +
         options_text(*command.app) + " \\\n    '1:command:" + name +
         "_commands' \\\n    '*::argument:->argument'\n  if [[ $state == argument ]]; then\n    case $line[1] in\n" +
         cases + "    esac\n  fi\n}\n\n";
}

}  // namespace

std::string zsh_completion(const CLI::App& root) {
  std::string out = kZshHead;
  std::vector<ListedCommand> commands = listed_commands(root);
  commands.push_back({"", &root});
  for (const ListedCommand& command : commands) {
    out += command.app->get_subcommands([](const CLI::App* sub) { return !sub->get_name().empty(); }).empty()
               ? leaf(command)
               : branch(command);
  }
  return out + "_reamsim \"$@\"\n";
}

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
