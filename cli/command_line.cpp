// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/command_line.h"

#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <utility>

#include "cli/commands.h"
#include "sim/base/text.h"
#include "sim/mesh/mesh_io.h"
#include "sim/scenario/key_tree.h"

namespace reamsim {

namespace {

/// What an exit status means for a command; "": for the program as a whole.
struct Status {
  std::string_view command;
  Entry entry;
};
/// Of any command, unless a later entry is of the command itself.
constexpr std::string_view kAnyCommand = "*";
constexpr std::array<Status, 13> kStatuses{
    {{kAnyCommand, {"0", "done"}},
     {kAnyCommand, {"1", "the command failed"}},
     {"", {"1", "the command failed; of verify: a figure exceeds its tolerance; of sweep run: a run failed"}},
     {"run", {"1", "the run failed"}},
     {"sweep run", {"1", "the command failed, or a run of the study did"}},
     {"verify", {"1", "the command failed, or a figure exceeds its tolerance"}},
     {kAnyCommand, {"2", "the input is wrong; the message says what, where, and what to do"}},
     {"",
      {"75",
       "of run, sweep run, uq and validate: interrupted, with a checkpoint; the same command continues, of run with "
       "--resume"}},
     {"run", {"75", "interrupted, with a checkpoint: the same command with --resume continues"}},
     {"sweep run", {"75", "interrupted; the same command continues"}},
     {"uq", {"75", "interrupted; the same command continues"}},
     {"validate", {"75", "interrupted; the same command continues"}},
     {kAnyCommand, {"130", "interrupted"}}}};

/// Visits `app` and the groups of options that belong to it, which CLI11 keeps as nameless commands.
template <class Visit>
void for_each_group(const CLI::App& app, const Visit& visit) {
  visit(app);
  for (const CLI::App* below : app.get_subcommands([](const CLI::App* sub) { return sub->get_name().empty(); })) {
    for_each_group(*below, visit);
  }
}

/// The options of a command or group that help lists.
std::vector<const CLI::Option*> listed_options(const CLI::App& group) {
  return group.get_options([&](const CLI::Option* option) {
    const bool is_own_help = group.get_name().empty() && option == group.get_help_ptr();
    return option->nonpositional() && !option->get_group().empty() && !is_own_help;
  });
}

/// CLI11 writes the type as "TEXT:{law,classes}" or "INT:INT in [1 - 9]"; this program also as "osmesa|egl".
void set_value(const std::string& type, ArgumentText& out) {
  const std::size_t brace = type.find(":{");
  if (brace != std::string::npos) {
    out.choices = split(type.substr(brace + 2, type.size() - brace - 3), ',');
  } else if (type.find('|') != std::string::npos) {
    out.choices = split(type, '|');
  }
  const bool has_range = type.starts_with("INT") || type.starts_with("FLOAT");
  out.value = has_range ? type.substr(0, type.find(':')) : type;  // also HH:MM:SS
  if (!out.choices.empty()) out.value = fmt::format("{}", fmt::join(out.choices, "|"));
}

/// "1 to 1024" of CLI11's "INT:INT in [1 - 1024]"; "" without a range.
std::string range_of(const std::string& type) {
  const std::size_t bracket = type.find(" in [");
  if (bracket == std::string::npos) return "";
  const std::string range = type.substr(bracket + 5, type.size() - bracket - 6);
  const std::size_t dash = range.find(" - ");
  return range.substr(0, dash) + " to " + range.substr(dash + 3);
}

ArgumentText text_of(const CLI::Option& option) {
  ArgumentText out;
  for (const std::string& name : option.get_snames()) out.flags.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) out.flags.push_back("--" + name);
  // A flag such as --film takes a value only after "=".
  if (option.get_expected_min() > 0) set_value(option.get_type_name(), out);
  if (option.get_positional()) out.value = option.get_name(true, false);
  out.description = option.get_description();
  if (const std::string range = range_of(option.get_type_name()); !range.empty()) out.description += " (" + range + ")";
  std::vector<std::string> others;
  for (const CLI::Option* other : option.get_excludes()) others.push_back("--" + other->get_lnames().front());
  std::ranges::sort(others);
  if (!others.empty()) out.description += fmt::format(" (not with {})", fmt::join(others, ", "));
  out.required = option.get_required();
  out.repeats = option.get_expected_max() >= CLI::detail::expected_max_vector_size ||
                option.get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
  return out;
}

/// A term, and its meaning at a column of its own.
std::string entry_line(const std::string& term, std::string_view meaning) {
  constexpr std::size_t kColumn = 30;
  const std::string start = "  " + term;
  const std::string space = start.size() < kColumn ? "" : "\n";
  return start + space + std::string(kColumn - (space.empty() ? start.size() : 0), ' ') + std::string(meaning) + "\n";
}

std::string option_line(const CLI::Option& option) {
  const ArgumentText text = text_of(option);
  std::string term = fmt::format("{}", fmt::join(text.flags, ","));
  // CLI11 has a flag that takes a value after "=" as "--film{mp4}".
  if (option.get_expected_min() == 0 && option.get_name(false, true).find('{') != std::string::npos) term += "[=VALUE]";
  if (!text.value.empty()) term += " " + text.value;
  return entry_line(term + (text.required ? " (required)" : ""), text.description);
}

/// help_of() in place of CLI11's own help, which has the notation of the parser and differs from version to version.
class HelpFormatter : public CLI::FormatterBase {
 public:
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode /*mode*/) const override {
    const std::size_t space = name.find(' ');  // of "reamsim sweep run"
    return help_of({space == std::string::npos ? "" : name.substr(space + 1), app});
  }
};

}  // namespace

std::vector<const CLI::App*> commands_below(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* sub) { return !sub->get_group().empty() && !sub->get_name().empty(); });
}

std::vector<ListedCommand> listed_commands(const CLI::App& root) {
  std::vector<ListedCommand> out;
  for (const CLI::App* command : commands_below(root)) {
    out.push_back({command->get_name(), command});
    for (const auto& [name, app] : listed_commands(*command)) out.push_back({command->get_name() + " " + name, app});
  }
  return out;
}

std::string command_names(const CLI::App& root) {
  std::vector<std::string_view> names;
  for (const CLI::App* command : commands_below(root)) names.push_back(command->get_name());
  return join_or(names);
}

std::vector<ArgumentText> options_of(const CLI::App& command) {
  std::vector<ArgumentText> out;
  for_each_group(command, [&](const CLI::App& group) {
    for (const CLI::Option* option : listed_options(group)) out.push_back(text_of(*option));
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

std::vector<Entry> exit_statuses_of(const std::string& name) {
  std::vector<Entry> out;
  for (const Status& status : kStatuses) {
    if (status.command != name && status.command != kAnyCommand) continue;
    if (!out.empty() && out.back().term == status.entry.term) out.pop_back();
    out.push_back(status.entry);
  }
  return out;
}

std::string help_of(const ListedCommand& command) {
  std::string out = command.app->get_description() + "\nUsage: " + synopsis_of(command) + "\n", lines;
  const auto close = [&](const char* title) {
    if (!lines.empty()) out += std::string("\n") + title + ":\n" + std::exchange(lines, "");
  };
  for (const ArgumentText& argument : positionals_of(*command.app)) {
    lines += entry_line(argument.value, argument.description);
  }
  close("Positionals");
  for_each_group(*command.app, [&](const CLI::App& group) {
    for (const CLI::Option* option : listed_options(group)) lines += option_line(*option);
    close(&group == command.app ? "Options" : "One of these");
  });
  for (const CLI::App* below : commands_below(*command.app)) {
    lines += entry_line(below->get_name(), below->get_description());
  }
  close("Subcommands");
  for (const Entry& status : exit_statuses_of(command.name))
    lines += entry_line(std::string(status.term), status.meaning);
  close("Exit status");
  return out + "\nreamsim help COMMAND prints the options of a command, reamsim help --format man the man page.\n";
}

void set_help(CLI::App& app) {
  app.formatter(std::make_shared<HelpFormatter>());
}

void add_overrides(CLI::App& command, std::vector<std::string>& overrides, const std::string& what) {
  command.add_option("--set", overrides, what + "; repeatable")->type_name("KEY.PATH=VALUE")->expected(1)->take_all();
}

std::string lower_extension(const std::string& path) {
  return lower_case(std::filesystem::path(path).extension().string());
}

BoneSource source_of_file(const std::string& path) {
  const ContentKind content = content_kind(path);
  if (content == ContentKind::mesh) return BoneSource::mesh;
  if (content == ContentKind::vdb) return BoneSource::vdb;
  if (content == ContentKind::image) return BoneSource::ct;
  constexpr std::array kMeshes{".stl", ".obj", ".ply", ".vtp", ".vtk", ".off", ".3mf", ".step", ".stp", ".glb", ".fbx"};
  const std::string kind = lower_extension(path);
  if (kind == ".vdb") return BoneSource::vdb;
  return std::ranges::find(kMeshes, kind) != kMeshes.end() ? BoneSource::mesh : BoneSource::ct;
}

}  // namespace reamsim
