// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/study_folder.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <fmt/ranges.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <random>
#include <set>

#include "sim/base/checksum.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/record/result_json.h"
#include "sim/scenario/parse.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t kMostBytes = 16'000'000;  // of a summary or a note

[[noreturn]] void refuse_folder(const std::string& dir, const std::string& found, const std::string& expected) {
  throw InputError({dir, 0, 0}, "output folder", found, expected);
}

std::string mark_of(const std::string& dir) {
  return dir + "/study.json";
}

bool is_study(const std::string& dir) {
  const Json json = parse_result_json(read_file_start(mark_of(dir), kMostBytes));
  return json.is_object() && json.value("kind", Json()) == Json("study");
}

/// Whether a folder is empty, or holds only what another process has created before it marks the folder.
bool is_begun(const std::string& dir) {
  std::error_code error;
  for (fs::directory_iterator entry(dir, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    const bool empty_part = (name == "runs" || name == "failed") && fs::is_empty(entry->path(), error);
    if (!empty_part && !name.starts_with("study.json.")) return false;
  }
  return !error;
}

std::string absolute(const std::string& dir) {
  fs::path out = fs::absolute(dir).lexically_normal();
  if (!out.has_filename()) out = out.parent_path();
  if (!is_printable(out.string())) refuse_folder(dir, "is no UTF-8 on one line", "choose another name with -o");
  return out.string();
}

constexpr std::size_t kMostShown = 3;
/// Runs of the plan that are compared. Those of a larger plan differ from each other in what varies alone.
constexpr std::size_t kMostCompared = 200;

std::vector<std::string> differences_of(const ScenarioValues& there, const ScenarioValues& here) {
  std::map<std::string, std::array<std::string, 2>> both;
  for (const auto& [key, value] : there) both[key] = {printable(value), "missing"};
  for (const auto& [key, value] : here)
    both.try_emplace(key, std::array<std::string, 2>{"missing"}).first->second[1] = printable(value);
  std::vector<std::string> out;
  for (const auto& [key, values] : both) {
    if (values[0] != values[1])
      out.push_back(fmt::format("{} is {} there and {} in this plan", key, values[0], values[1]));
  }
  return out;
}

/// Those to the most similar run of the plan.
std::vector<std::string> least_differences(const ScenarioValues& there, const Study& study, const StudyPlan& plan,
                                           const std::vector<IdentifiedRun>& runs) {
  std::optional<std::vector<std::string>> least;
  for (std::size_t i = 0; i < std::min(runs.size(), kMostCompared); ++i) {
    if (runs[i].id.empty()) continue;
    const std::string here = to_yaml(scenario_of(study, plan.runs[i]));
    std::vector<std::string> found = differences_of(there, values_of_scenario(*parse_yaml(here, "plan")));
    if (!least || found.size() < least->size()) least = std::move(found);
  }
  return least.value_or(std::vector<std::string>{});
}

}  // namespace

StudyFolder::StudyFolder(const Study& study, const std::string& dir) : dir_(absolute(dir)), keep_(study.keep) {
  std::error_code error;
  // Another shard may create the folder at the same time, and mark it between the two looks.
  if (fs::exists(fs::symlink_status(dir_, error)) && !is_study(dir_) && !is_begun(dir_) && !is_study(dir_))
    refuse_folder(dir_, "exists and is not the folder of a study", "choose another with -o");
  for (const char* part : {"/runs", "/failed"}) {
    fs::create_directories(dir_ + part, error);
    if (error) refuse_folder(dir_, "cannot be created", "choose a writable place with -o");
  }
  mark(study);
}

StudyFolder StudyFolder::open(const Study& study, const std::string& dir) {
  const std::string path = absolute(dir);
  if (!is_study(path)) refuse_folder(path, "holds no study", "run `reamsim sweep run` first, or name it with -o");
  return {path, study.keep};
}

void StudyFolder::mark(const Study& study) const {
  const Json json{{"program", "reamsim " REAMSIM_VERSION}, {"kind", "study"}, {"study", study.name}};
  if (is_study(dir_) && read_file_start(mark_of(dir_), kMostBytes) == json.dump(2) + "\n") return;
  // Shards on several machines may do so at the same time: each writes a file of its own.
  std::random_device random;
  const std::string own = fmt::format("{}.{:08x}{:08x}", mark_of(dir_), random(), random());
  replace_file(own, json.dump(2) + "\n");
  std::error_code error;
  fs::rename(own, mark_of(dir_), error);
  if (error) fail_to_write(mark_of(dir_));
}

RunState StudyFolder::state(const std::string& id) const {
  std::error_code error;
  const auto manifest = read_manifest(run_dir(id));
  const auto has = [&](const char* name) {
    return manifest->files.contains(name) && fs::file_size(run_dir(id) + "/" + name, error) > 0 && !error;
  };
  if (manifest && manifest->complete && has("summary.json") && has("scenario.yaml") &&
      (!keep_.forces || has("forces.csv")) && (!keep_.grids || has("reamed.vdb")) &&
      (!keep_.pictures || has("forces.png")) &&
      parse_result_json(read_file_start(run_dir(id) + "/summary.json", kMostBytes)).is_object()) {
    return RunState::done;
  }
  // Before the unfinished folder, which a process that the system ended leaves as well.
  if (fs::exists(dir_ + "/failed/" + id + ".json", error)) return RunState::failed;
  return fs::exists(run_dir(id) + ".partial", error) ? RunState::interrupted : RunState::missing;
}

std::string StudyFolder::failure(const std::string& id) const {
  const Json json = parse_result_json(read_file_start(dir_ + "/failed/" + id + ".json", kMostBytes));
  const Json message = json.is_object() ? json.value("message", Json()) : Json();
  return message.is_string() ? message.get<std::string>() : "";
}

void StudyFolder::note_failure(const std::string& id, const std::string& message) const {
  const Json json{{"run", id}, {"message", printable(message)}};
  replace_file(dir_ + "/failed/" + id + ".json", json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

void StudyFolder::forget_failure(const std::string& id) const {
  std::error_code ignored;
  fs::remove(dir_ + "/failed/" + id + ".json", ignored);
}

void StudyFolder::sync() const {
  const int folder = ::open(dir_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool synced = folder >= 0 && syncfs(folder) == 0;
  if (folder >= 0) close(folder);
  if (!synced) fail_to_write(dir_);
}

std::string run_id(const Scenario& scenario, const KeptFiles& keep, Checksums& checksums) {
  Scenario counted = scenario;
  counted.name.clear();
  counted.output = {};
  counted.output.force_basis = scenario.output.force_basis;
  if (!keep.pictures) counted.render = {};
  std::set<std::string> inputs;
  for (const auto& [role, path] : input_files(scenario)) {
    inputs.insert(path);
    if (!checksums.contains(path)) checksums[path] = sha256_of(path);
  }
  const auto sum_of = [&](const std::string& path) { return inputs.contains(path) ? checksums.at(path) : path; };
  constexpr std::size_t kDigits = 16;  // 64 bits: a collision among a million runs has a probability of 3e-8
  return sha256_of_text("reamsim " REAMSIM_VERSION "\n" + to_yaml(counted, sum_of)).substr(0, kDigits);
}

std::string text_of_other_runs(const Study& study, const StudyPlan& plan, const std::vector<IdentifiedRun>& runs,
                               const StudyFolder& folder) {
  std::set<std::string> own;
  for (const IdentifiedRun& run : runs) own.insert(run.id);
  std::vector<std::string> others = finished_runs(folder.path());
  std::erase_if(others, [&](const std::string& id) { return own.contains(id) || folder.state(id) != RunState::done; });
  if (others.empty()) return "";
  const std::string dir = folder.path() + "/runs", file = folder.run_dir(others.front()) + "/scenario.yaml";
  const std::string begin =
      others.size() == 1 ? fmt::format("1 result in {} belongs to another plan of this study", dir)
                         : fmt::format("{} results in {} belong to another plan of this study", others.size(), dir);
  std::vector<std::string> differences;
  try {
    const YamlNodePtr there = parse_yaml(read_file(file, "the scenario of a run"), file);
    differences = least_differences(values_of_scenario(*there), study, plan, runs);
  } catch (const InputError&) {
    // Damaged: the count stays true.
  }
  if (differences.empty()) {
    return begin + ": the version of the program, the contents of an input file or a key of output or render differs";
  }
  differences.resize(std::min(differences.size(), kMostShown));
  return fmt::format("{}: {}; give the same --set as for sweep run, or the same study", begin,
                     fmt::join(differences, ", "));
}

}  // namespace reamsim
