// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <span>

#include "cli/command_line.h"
#include "cli/commands.h"
#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/scenario/paths.h"

namespace reamsim {

namespace {

constexpr std::array<Entry, 9> kVariables{
    {{"NO_COLOR", "If set and not empty, messages on a terminal have no colours. Elsewhere they never have."},
     {"TERM", "With dumb, progress is printed as lines and messages have no colours."},
     {"POCL_CACHE_DIR", "Folder for compiled OpenCL kernels."},
     {"XDG_CACHE_HOME",
      "Without POCL_CACHE_DIR, kernels are in its folder pocl/kcache; without both, in .cache/pocl/kcache of HOME."},
     {"TMPDIR", "Folder for compiled kernels where none of these can be written; otherwise /tmp."},
     {"POCL_MAX_PTHREAD_COUNT", "Maximum number of threads of the OpenCL device PoCL."},
     {"POCL_AFFINITY", "1, the default of reamsim, binds the threads of PoCL to processors; 0 does not."},
     {"REAMSIM_PYTHON",
      "The Python that computes the statistics of fit, uq and sweep; otherwise /usr/bin/python3, or python3 of PATH."},
     {"HOME", "Replaces ${HOME} in a scenario, as any variable ${NAME} is replaced there."}}};

constexpr std::array<Entry, 5> kExamples{
    {{"reamsim check my.yaml", "Validates a scenario and estimates time and memory."},
     {"reamsim run my.yaml -o out/my", "Simulates it. Open out/my/report.html afterwards."},
     {"reamsim run my.yaml --set bone.voxel_mm=0.3 -o out/fine", "The same with smaller voxels."},
     {"reamsim render out/my --film", "Makes a film of the finished run."},
     {"reamsim cite out/my", "Prints what a paper about this run should cite."}}};

/// The scripts of the shells ask the program what can stand at the place of the last word: completions().
constexpr const char* kBash = R"bash(# bash completion for reamsim; written by: reamsim help --format bash

_reamsim()
{
    local current=${COMP_WORDS[COMP_CWORD]#=} program=${COMP_WORDS[0]/#\~\//$HOME/} IFS=$'\n' word
    COMPREPLY=()
    while IFS=$'\t' read -r word _; do
        case $word in
            :*)
                compopt -o filenames 2>/dev/null
                COMPREPLY+=( $(compgen -d -- "$current") )
                [ "$word" = :folders ] || COMPREPLY+=( $(compgen -f -X "!*${word#:files}" -- "$current" |
                    while read -r path; do [ -d "$path" ] || printf '%s\n' "$path"; done) ) ;;
            "$current"*) COMPREPLY+=( "$word" ) ;;
        esac
    done < <("$program" help --words -- "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null)
}

complete -F _reamsim reamsim
)bash";

constexpr const char* kZsh = R"zsh(#compdef reamsim
# zsh completion for reamsim; written by: reamsim help --format zsh

_reamsim() {
  local line ret=1
  local -a lines described
  lines=(${(f)"$(_call_program words $words[1] help --words -- "${(@q)words[2,CURRENT]}" 2>/dev/null)"})
  compset -P '--*='
  for line in $lines; do
    case $line in
      (:folders) _files -/ && ret=0 ;;
      (:files*) _files -g "*${line#:files}" && ret=0 ;;
      (*) described+=("${line/$'\t'/:}") ;;
    esac
  done
  (( $#described )) && _describe reamsim described && ret=0
  return ret
}

_reamsim "$@"
)zsh";

std::string lines_of(const std::vector<std::string>& names) {
  std::string out;
  for (const std::string& name : names) out += name + "\n";
  return out;
}

std::string command_lines(const CLI::App& app) {
  std::string out;
  for (const CLI::App* sub : commands_below(app)) out += sub->get_name() + "\t" + sub->get_description() + "\n";
  return out;
}

std::string option_lines(const std::vector<ArgumentText>& options) {
  std::string out;
  for (const ArgumentText& option : options) {
    for (const std::string& flag : option.flags) out += flag + "\t" + option.description + "\n";
  }
  return out;
}

/// By the name of the value, such as DIR or FILE.csv.
std::string value_lines(const ArgumentText& argument, const CLI::App& root) {
  const std::string& value = argument.value;
  if (!argument.choices.empty()) return lines_of(argument.choices);
  if (value == "COMMAND") return command_lines(root);
  if (value == "STUDY") return lines_of(shipped_names(ShippedKind::study)) + ":files.yaml\n:files.yml\n";
  const std::string scenarios = lines_of(shipped_names(ShippedKind::scenario));
  if (value.starts_with("SCENARIO")) return scenarios + ":files.yaml\n:files.yml\n";
  if (value == "DIR") return ":folders\n";
  // A bone, which may also be that of a scenario: the description says where a name is taken.
  if (value == "INPUT" && argument.description.find("shipped") != std::string::npos) return scenarios + ":files\n";
  const bool file = value.starts_with("FILE") || value == "MESH" || value == "INPUT" || value == "MEASURED.csv";
  return file ? ":files\n" : "";
}

/// What can stand at the place of the last word after the program: lines with a word and, after a tab, what it means;
/// :folders, or :files and how their names end.
std::string completions(const CLI::App& root, std::vector<std::string> words) {
  std::string current = words.empty() ? "" : words.back();
  if (!words.empty()) words.pop_back();
  if (const std::size_t equals = current.find('='); current.starts_with("--") && equals != std::string::npos) {
    words.push_back(current.substr(0, equals));
    current.erase(0, equals + 1);
  }
  const CLI::App* command = &root;
  std::vector<ArgumentText> options = options_of(root);
  std::optional<ArgumentText> of_value;  // the option whose value is the next word
  std::size_t given = 0;                 // arguments by position
  for (const std::string& word : words) {
    if (word == "=") continue;  // of --output=DIR, which bash splits
    const auto has_word = [&](const ArgumentText& option) { return std::ranges::count(option.flags, word) > 0; };
    const auto option = std::ranges::find_if(options, has_word);
    const auto commands = listed_commands(*command);
    const auto below = std::ranges::find(commands, word, &ListedCommand::name);
    if (of_value) {
      of_value.reset();
    } else if (option != options.end()) {
      if (!option->value.empty()) of_value = *option;
      if (!option->repeats) options.erase(option);
    } else if (below != commands.end()) {
      command = below->app;
      options = options_of(*command);
    } else {
      ++given;
    }
  }
  if (of_value) return value_lines(*of_value, root);
  if (current.starts_with('-')) return option_lines(options);
  const std::vector<ArgumentText> positionals = positionals_of(*command);
  const bool repeats = !positionals.empty() && positionals.back().repeats;
  const std::size_t place = repeats ? std::min(given, positionals.size() - 1) : given;
  return command_lines(*command) + (place < positionals.size() ? value_lines(positionals[place], root) : "");
}

/// Text that roff prints as it is.
std::string escaped(std::string_view text) {
  return replace_all(text,
                     {{"\\", "\\e"}, {"-", "\\-"}, {"'", "\\(aq"}, {"`", "\\(ga"}, {"^", "\\(ha"}, {"~", "\\(ti"}});
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

std::string arguments(const std::vector<ArgumentText>& list) {
  std::string out;
  for (const ArgumentText& argument : list) {
    std::string term;
    for (const std::string& flag : argument.flags) term += (term.empty() ? "" : ", ") + bold(flag);
    if (!argument.value.empty()) term += (term.empty() ? "" : " ") + italic(argument.value);
    out += ".TP\n" + term + (argument.repeats ? "..." : "") + "\n";
    out += line(argument.description + (argument.required && !argument.flags.empty() ? " (required)" : ""));
  }
  return out;
}

/// reamsim(1) for man(7): all commands and options of `root`.
std::string man_page(const CLI::App& root) {
  std::string out = ".TH REAMSIM 1 \"\" \"reamsim " REAMSIM_VERSION "\" \"User Commands\"\n";
  out += section("NAME") + "reamsim \\- simulate glenoid reaming\n";
  out += section("SYNOPSIS") + bold("reamsim") + " " + italic("COMMAND") + " [" + italic("OPTIONS") + "]\n";
  out += section("DESCRIPTION") + line(kDescription);
  out += ".PP\n" + line(
                       "A scenario is one YAML file: bone, reamer and motion. In the documentation of the package, "
                       "keys.md has its keys and results.md the files of a run.");
  out += section("OPTIONS") + arguments(options_of(root));
  out += section("COMMANDS");
  for (const ListedCommand& command : listed_commands(root)) {
    out += ".SS \"" + escaped(synopsis_of(command)) + "\"\n" + line(command.app->get_description());
    out += arguments(positionals_of(*command.app)) + arguments(options_of(*command.app));
  }
  out += section("\"EXIT STATUS\"") + entries(exit_statuses_of(""));
  out += section("ENVIRONMENT") + entries(kVariables);
  out += section("EXAMPLES") + entries(kExamples);
  out += section("\"SEE ALSO\"") + ".BR gnuplot (1),\n.BR ffmpeg (1),\n.BR clinfo (1)\n";
  return out;
}

struct HelpOptions {
  std::vector<std::string> words;
  std::string format = "text";
  bool completes = false;  ///< a shell asks what can stand at the place of the last word
};

/// The command that the words name, such as "sweep run". Throws InputError.
ListedCommand named_command(const CLI::App& root, const std::vector<std::string>& words) {
  const std::string name = fmt::format("{}", fmt::join(words, " "));
  if (name.empty()) return {"", &root};
  const std::vector<ListedCommand> commands = listed_commands(root);
  const auto found = std::ranges::find(commands, name, &ListedCommand::name);
  if (found != commands.end()) return *found;
  throw InputError({}, "", name + ": unknown command", "expected " + command_names(root));
}

std::string text_of(const CLI::App& root, const HelpOptions& options) {
  if (options.format != "text" && !options.words.empty()) {
    throw InputError({}, "--format", options.format + " is of the whole program", "leave the command out");
  }
  if (options.completes) return completions(root, options.words);
  if (options.format == "man") return man_page(root);
  if (options.format == "bash") return kBash;
  if (options.format == "zsh") return kZsh;
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
  command->add_flag("--words", options->completes)->group("");  // not listed: only the completion of a shell asks
  command->callback([options, &app] { std::fputs(text_of(app, *options).c_str(), stdout); });
}

}  // namespace reamsim
