// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/study_folder.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <random>

#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/record/manifest.h"
#include "sim/record/result_json.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t kMostBytes = 16'000'000;  // of a summary or a note

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
  if (!is_printable(out.string())) {
    throw InputError({dir, 0, 0}, "output folder", "is no UTF-8 on one line", "choose another name with -o");
  }
  return out.string();
}

}  // namespace

StudyFolder::StudyFolder(const Study& study, const std::string& dir) : dir_(absolute(dir)), keep_(study.keep) {
  std::error_code error;
  // Another shard may create the folder at the same time, and mark it between the two looks.
  if (fs::exists(fs::symlink_status(dir_, error)) && !is_study(dir_) && !is_begun(dir_) && !is_study(dir_)) {
    throw InputError({dir_, 0, 0}, "output folder", "exists and is not the folder of a study",
                     "choose another with -o");
  }
  for (const char* part : {"/runs", "/failed"}) {
    fs::create_directories(dir_ + part, error);
    if (error) {
      throw InputError({dir_, 0, 0}, "output folder", "cannot be created", "choose a writable place with -o");
    }
  }
  mark(study);
}

StudyFolder StudyFolder::open(const Study& study, const std::string& dir) {
  const std::string path = absolute(dir);
  if (!is_study(path)) {
    throw InputError({path, 0, 0}, "output folder", "holds no study",
                     "run `reamsim sweep run` first, or name it with -o");
  }
  return {path, study.keep};
}

void StudyFolder::mark(const Study& study) const {
  Json json;
  json["program"] = "reamsim " REAMSIM_VERSION;
  json["kind"] = "study";
  json["study"] = study.name;
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
  const auto has_whole_summary = [&] {
    return parse_result_json(read_file_start(run_dir(id) + "/summary.json", kMostBytes)).is_object();
  };
  if (manifest && manifest->complete && has("summary.json") && has_whole_summary() && has("scenario.yaml") &&
      (!keep_.forces || has("forces.csv")) && (!keep_.grids || has("reamed.vdb")) &&
      (!keep_.pictures || has("forces.png"))) {
    return RunState::done;
  }
  // Before the unfinished folder, which a process that the system ended leaves as well.
  if (fs::exists(dir_ + "/failed/" + id + ".json", error)) return RunState::failed;
  return fs::exists(run_dir(id) + ".partial", error) ? RunState::interrupted : RunState::missing;
}

std::vector<std::string> StudyFolder::run_names() const {
  std::vector<std::string> out;
  std::error_code error;
  for (fs::directory_iterator entry(dir_ + "/runs", error), end; !error && entry != end; entry.increment(error)) {
    if (entry->path().extension().empty()) out.push_back(entry->path().filename().string());
  }
  std::ranges::sort(out);
  return out;
}

std::string StudyFolder::failure(const std::string& id) const {
  const Json json = parse_result_json(read_file_start(dir_ + "/failed/" + id + ".json", kMostBytes));
  if (!json.is_object() || !json.contains("message") || !json["message"].is_string()) return "";
  return json["message"].get<std::string>();
}

void StudyFolder::note_failure(const std::string& id, const std::string& message) const {
  Json json;
  json["run"] = id;
  json["message"] = printable(message);
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

}  // namespace reamsim
