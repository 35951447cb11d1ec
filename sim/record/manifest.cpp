// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <filesystem>
#include <vector>

#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/record/output_folder.h"
#include "sim/record/result_json.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

using Json = nlohmann::ordered_json;

/// What results of a kind are called in a manifest, and the names of their files, relative to the results folder; a
/// finished folder has at least one of `marks`.
struct KindOfResults {
  const char* name;
  Pattern files;
  std::vector<std::string> marks;
};

std::string files_of_run() {
  const std::string files =
      "CITATION\\.txt|scenario\\.yaml|report\\.html|(summary|verification)\\.json|timings\\.csv|"
      "(segmentation|contact_sheet)\\.png|forces\\.(csv|gp|png|svg|pdf)|force_basis\\.npy|events\\.csv|"
      "depth_map\\.(csv|png)|clearance\\.csv|planning\\.mrk\\.json|reamed\\.(vdb|vti|seg\\.nrrd|glb|stl)|"
      "(reamed|turntable)\\.(mp4|webp|apng)|"
      "snapshots/([0-9]+\\.vdb|tool(_[0-9]+)?\\.stl)|turntable/[0-9]+\\.png|"
      "plots/(forces_decimated|forces_depth|energy|removed_density|spectrum|push|deflection)\\.(csv|gp|png|svg|pdf)";
  const std::string camera = "(_[a-z0-9_-]+)?";           // the names that render.user_cameras may have
  const std::string unfinished = "(\\.tmp|\\.partial)?";  // of an interrupted write
  return "(" + files + "|(reamed|before_after|frames/[0-9]+)" + camera + "\\.png)" + unfinished;
}

const KindOfResults& kind_of(ResultKind kind) {
  static const KindOfResults kinds[] = {
      {"run", Pattern(files_of_run()), {"scenario.yaml", "summary.json"}},
      {"comparison", Pattern("CITATION\\.txt|compare\\.(csv|gp|png|svg|pdf)|(curves|runs)\\.csv"), {"compare.csv"}},
      {"verification",
       Pattern("CITATION\\.txt|device\\.md|verification\\.(md|json|gp|png|svg)"),
       {"verification.json"}},
      {"benchmark", Pattern("CITATION\\.txt|bench\\.(json|gp|png|svg)"), {"bench.gp"}},
  };  // in the order of ResultKind
  return kinds[static_cast<std::size_t>(kind)];
}

/// Files that only unfinished results have: ours, and in no manifest. A process that is killed may leave them in
/// complete ones.
bool is_of_unfinished(const std::string& place, ResultKind kind) {
  static const Pattern checkpoints("checkpoint-[01]\\.bin(\\.tmp)?");
  if (place == std::string(kManifestName) + ".tmp") return true;
  return kind == ResultKind::run && checkpoints.matches(place);
}

constexpr const char* kFolders[] = {"frames", "plots", "snapshots", "turntable"};

/// Users copy it into a run, whose report then shows it (docs/figures.md).
constexpr const char* kVerification = "verification.json";

/// Says which entries of a results folder reamsim wrote: those of its manifest; without a complete one, also those
/// with known names.
class OwnEntries {
 public:
  OwnEntries(const std::string& dir, ResultKind kind)
      : kind_(kind), names_(kind_of(kind).files), manifest_(read_manifest(dir)) {
    if (manifest_ && manifest_->kind != kind_of(kind).name) manifest_.reset();
  }

  [[nodiscard]] bool has_manifest() const { return manifest_.has_value(); }

  /// `place`: relative to the results folder. Links are never followed and never ours.
  [[nodiscard]] bool contains(const fs::directory_entry& entry, const std::string& place) const {
    std::error_code error;
    const fs::file_type type = entry.symlink_status(error).type();
    if (type == fs::file_type::directory) {
      return kind_ == ResultKind::run && std::ranges::find(kFolders, place) != std::end(kFolders);
    }
    if (type != fs::file_type::regular) return false;
    if (is_of_unfinished(place, kind_)) return true;
    if (manifest_ && (place == kManifestName || manifest_->files.contains(place))) return true;
    if (kind_ == ResultKind::run && place == kVerification) return true;
    return (!manifest_ || !manifest_->complete) && names_.matches(place);
  }

 private:
  ResultKind kind_;
  const Pattern& names_;  // made before results are written: to remove them must not need the memory
  std::optional<Manifest> manifest_;
};

/// Calls visit(entry, place, ours) for every entry of `dir` and of its folders that are ours, until it returns false.
/// `below`: the path of `dir` in the results folder, "" or "frames/". Returns false where `visit` did or an entry
/// cannot be read.
template <class Visit>
bool walk(const std::string& dir, const std::string& below, const OwnEntries& own, const Visit& visit) {
  std::error_code error;
  std::vector<fs::directory_entry> entries;
  for (fs::directory_iterator at(dir, error), end; !error && at != end; at.increment(error)) entries.push_back(*at);
  if (error) return false;
  std::ranges::sort(entries);
  for (const fs::directory_entry& entry : entries) {
    const std::string place = below + entry.path().filename().string();
    const bool ours = own.contains(entry, place);
    const bool folder = entry.symlink_status(error).type() == fs::file_type::directory;
    if (folder && ours && !walk(entry.path().string(), place + "/", own, visit)) return false;
    if (!visit(entry, place, ours)) return false;
  }
  return true;
}

}  // namespace

std::optional<Manifest> read_manifest(const std::string& dir) {
  constexpr std::size_t kMostBytes = 64'000'000;  // a million pictures
  const Json json = parse_result_json(read_file_start(dir + "/" + kManifestName, kMostBytes));
  try {
    return Manifest{.kind = json.at("kind").get<std::string>(),
                    .files = json.at("files").get<std::set<std::string>>(),
                    .complete = json.value("complete", true)};
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

void write_manifest(const std::string& dir, const Manifest& manifest, bool durable) {
  const Json json{{"program", "reamsim " REAMSIM_VERSION},
                  {"kind", manifest.kind},
                  {"complete", manifest.complete},
                  {"files", manifest.files}};
  const std::string path = dir + "/" + kManifestName, text = json.dump(2) + "\n";
  durable ? replace_file(path, text) : write_file(path, text);
}

std::optional<std::string> foreign_entry(const std::string& dir, ResultKind kind) {
  std::optional<std::string> found;
  const bool read =
      walk(dir, "", OwnEntries(dir, kind), [&](const fs::directory_entry&, const std::string& place, bool ours) {
        if (!ours) found = place;
        return ours;
      });
  if (!read && !found) return "something that cannot be read";
  return found;
}

bool is_marked(const std::string& dir, ResultKind kind) {
  if (OwnEntries(dir, kind).has_manifest()) return true;
  return std::ranges::any_of(kind_of(kind).marks, [&](const std::string& mark) {
    std::error_code error;
    return fs::is_regular_file(dir + "/" + mark, error);
  });
}

void list_results(const std::string& dir, ResultKind kind, const std::set<std::string>& foreign, bool durable) {
  Manifest manifest{.kind = kind_of(kind).name, .files = {}};
  walk(dir, "", OwnEntries(dir, kind), [&](const fs::directory_entry& entry, const std::string& place, bool ours) {
    std::error_code error;
    const bool file = entry.symlink_status(error).type() == fs::file_type::regular;
    const bool listed = ours && file && place != kManifestName && !is_of_unfinished(place, kind);
    if (listed && !foreign.contains(place)) manifest.files.insert(place);
    return true;
  });
  write_manifest(dir, manifest, durable);
}

std::set<std::string> open_results(const std::string& dir, ResultKind kind) {
  std::set<std::string> foreign;
  std::optional<Manifest> manifest = read_manifest(dir);
  if (!manifest || manifest->kind != kind_of(kind).name) return foreign;
  if (manifest->complete) {
    walk(dir, "", OwnEntries(dir, kind), [&](const fs::directory_entry&, const std::string& place, bool ours) {
      if (!ours) foreign.insert(place);
      return true;
    });
  }
  manifest->complete = false;
  write_manifest(dir, *manifest);
  return foreign;
}

bool remove_results(const std::string& dir, ResultKind kind) {
  std::error_code ignored;
  walk(dir, "", OwnEntries(dir, kind), [&](const fs::directory_entry& entry, const std::string&, bool ours) {
    if (ours) fs::remove(entry.path(), ignored);  // a folder only once it is empty
    return true;
  });
  fs::remove(dir, ignored);
  return !fs::exists(fs::symlink_status(dir, ignored));
}

}  // namespace reamsim
