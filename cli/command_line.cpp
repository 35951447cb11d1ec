// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <sstream>
#include <tuple>
#include <utility>

#include "cli/commands.h"
#include "cli/manual.h"
#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/mesh/mesh_io.h"
#include "sim/scenario/parse.h"

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
  out.value = type.substr(0, type.find(':'));
  if (type.find(':') != std::string::npos && brace == std::string::npos && !type.starts_with("INT") &&
      !type.starts_with("FLOAT")) {
    out.value = type;  // HH:MM:SS
  }
  if (out.choices.empty()) return;
  out.value.clear();
  for (const std::string& choice : out.choices) out.value += (out.value.empty() ? "" : "|") + choice;
}

/// "1 to 1024" of CLI11's "INT:INT in [1 - 1024]"; "" without a range.
std::string range_of(const std::string& type) {
  const std::size_t bracket = type.find(" in [");
  if (bracket == std::string::npos) return "";
  const std::string range = type.substr(bracket + 5, type.size() - bracket - 6);
  const std::size_t dash = range.find(" - ");
  return range.substr(0, dash) + " to " + range.substr(dash + 3);
}

/// The options that cannot be given beside this one, sorted.
std::string others_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const CLI::Option* other : option.get_excludes()) names.push_back("--" + other->get_lnames().front());
  std::ranges::sort(names);
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "" : ", ") + name;
  return out;
}

ArgumentText text_of(const CLI::Option& option) {
  ArgumentText out;
  for (const std::string& name : option.get_snames()) out.flags.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) out.flags.push_back("--" + name);
  // A flag such as --film takes a value only after "=".
  if (option.get_expected_min() > 0) set_value(option.get_type_name(), out);
  if (option.get_positional()) out.value = option.get_name(true, false);
  out.description = option.get_description();
  for (const auto& [begin, more] :
       {std::pair{" (", range_of(option.get_type_name())}, {" (not with ", others_of(option)}}) {
    if (!more.empty()) out.description += begin + more + ")";
  }
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

/// A term, and its meaning at a column of its own.
std::string entry_line(const std::string& term, std::string_view meaning) {
  constexpr std::size_t kColumn = 30;
  const std::string start = "  " + term;
  const std::string space = start.size() < kColumn ? "" : "\n";
  return start + space + std::string(kColumn - (space.empty() ? start.size() : 0), ' ') + std::string(meaning) + "\n";
}

std::string option_line(const CLI::Option& option) {
  const ArgumentText text = text_of(option);
  std::string term;
  for (const std::string& flag : text.flags) term += (term.empty() ? "" : ",") + flag;
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
  for (const ListedCommand& below : listed_commands(*command.app)) {
    if (below.name.find(' ') == std::string::npos) lines += entry_line(below.name, below.app->get_description());
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

namespace {

constexpr const char* kTuningVariable = "REAMSIM_ENGINE_TUNING";

/// Sets one member from "name=value"; false where the text is none of them.
bool set_tuning(EngineTuning& tuning, const std::string& text) {
  const std::string name = text.substr(0, text.find('='));
  const std::string value = name.size() < text.size() ? text.substr(name.size() + 1) : "";
  if (name == "kernel_shape" && from_name<KernelShape>(value)) {
    tuning.kernel_shape = *from_name<KernelShape>(value);
    return true;
  }
  for (const auto& [flag, member] : {std::pair{"culling", &tuning.culling}, std::pair{"windows", &tuning.windows}}) {
    if (name != flag || (value != "true" && value != "false")) continue;
    *member = value == "true";
    return true;
  }
  const char* const end = value.data() + value.size();
  return name == "work_group_size" && std::from_chars(value.data(), end, tuning.work_group_size).ptr == end &&
         tuning.work_group_size >= 0;
}

EngineTuning tuning_of_environment() {
  EngineTuning tuning;
  const char* const given = std::getenv(kTuningVariable);
  std::istringstream words(given == nullptr ? "" : given);
  for (std::string word; words >> word;) {
    if (!set_tuning(tuning, word)) {
      throw InputError(
          {}, kTuningVariable, "found " + word,
          "expected kernel_shape=auto|cpu|gpu, culling=true|false, windows=true|false or work_group_size=N");
    }
  }
  return tuning;
}

}  // namespace

void add_overrides(CLI::App& command, std::vector<std::string>& overrides, const std::string& what) {
  command.add_option("--set", overrides, what + "; repeatable")->type_name("KEY.PATH=VALUE")->expected(1)->take_all();
}

void ScenarioOptions::add_to(CLI::App& command) {
  take_shipped_names(
      *command.add_option("SCENARIO", file, "Scenario file (YAML), or the name of a shipped one")->required(),
      ShippedKind::scenario);
  add_overrides(command, overrides, "Override a key of the scenario, for example bone.voxel_mm=0.4");
  command.add_option("--device", device, "auto, serial, or part of the name of an OpenCL device")->type_name("NAME");
  command.add_option("--engine", engine, "Engine (default: that of the scenario)")
      ->type_name("auto|exact|bricked|direct|octree|implicit");
}

Scenario ScenarioOptions::parse() const {
  std::vector<std::string> all = overrides;
  for (const auto& [option, value, key] :
       {std::tuple{"--device", &device, "engine.device="}, std::tuple{"--engine", &engine, "engine.type="}}) {
    const bool twice = !value->empty() && std::ranges::any_of(overrides, [prefix = key](const std::string& set) {
      return set.starts_with(prefix);
    });
    if (twice) throw InputError({}, option, std::string("given beside --set ") + key + "...", "give one of them");
  }
  if (!device.empty()) all.push_back("engine.device=" + device);
  if (!engine.empty()) all.push_back("engine.type=" + engine);
  Scenario scenario = parse_scenario(file, all);
  scenario.engine.tuning = tuning_of_environment();
  return scenario;
}

std::string lower_extension(const std::string& path) {
  std::string text = std::filesystem::path(path).extension().string();
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

BoneSource source_of_file(const std::string& path) {
  switch (content_kind(path)) {
    case ContentKind::mesh:
      return BoneSource::mesh;
    case ContentKind::vdb:
      return BoneSource::vdb;
    case ContentKind::image:
      return BoneSource::ct;
    case ContentKind::unknown:
      break;
  }
  constexpr std::array kMeshes{".stl", ".obj", ".ply", ".vtp", ".vtk", ".off", ".3mf", ".step", ".stp", ".glb", ".fbx"};
  const std::string kind = lower_extension(path);
  if (kind == ".vdb") return BoneSource::vdb;
  return std::ranges::find(kMeshes, kind) != kMeshes.end() ? BoneSource::mesh : BoneSource::ct;
}

void take_shipped_names(CLI::Option& option, ShippedKind kind) {
  option.transform([kind](const std::string& argument) { return shipped_or_path(argument, kind); }, "");
}

}  // namespace reamsim
