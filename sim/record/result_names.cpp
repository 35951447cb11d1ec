#include "sim/record/result_names.h"

#include <algorithm>
#include <filesystem>
#include <regex>
#include <vector>

namespace reamsim {

namespace {

namespace fs = std::filesystem;

/// Names of files relative to the results folder; a finished folder has at least one of `marks`.
struct Names {
  std::regex files;
  std::vector<std::string> marks;
};

Names names_of_run() {
  const std::string camera = "(_[a-z0-9_-]+)?";           // the names that render.user_cameras may have
  const std::string unfinished = "(\\.tmp|\\.partial)?";  // of an interrupted write
  const std::string files =
      "scenario\\.yaml|summary\\.json|verification\\.json|timings\\.csv|report\\.html|segmentation\\.png|contact_"
      "sheet\\.png|"
      "forces\\.(csv|gp|png|svg|pdf)|depth_map\\.(csv|png)|reamed\\.(vdb|vti|glb|stl)|"
      "(reamed|turntable)\\.(mp4|webp|apng)|snapshots/([0-9]+\\.vdb|tool\\.stl)|turntable/[0-9]+\\.png|"
      "plots/(forces_depth|energy|removed_density|spectrum)\\.(csv|gp|png|svg|pdf)";
  const std::string pictures = "(reamed|before_after|frames/[0-9]+)" + camera + "\\.png";
  return {std::regex("(" + files + "|" + pictures + ")" + unfinished), {"scenario.yaml", "summary.json"}};
}

const Names& names_of(ResultKind kind) {
  static const Names names[] = {
      names_of_run(),
      {std::regex("compare\\.(csv|gp|png|svg|pdf)|curves\\.csv"), {"compare.csv"}},
      {std::regex("verification\\.(md|json|gp|png|svg)"), {"verification.json"}},
      {std::regex("bench\\.(json|gp|png|svg)"), {"bench.gp"}},
  };  // in the order of ResultKind
  return names[static_cast<std::size_t>(kind)];
}

constexpr const char* kFolders[] = {"frames", "plots", "snapshots", "turntable"};

/// `place`: relative to the results folder. Links are never followed and never ours.
bool is_ours(const fs::directory_entry& entry, const std::string& place, ResultKind kind) {
  std::error_code error;
  const fs::file_type type = entry.symlink_status(error).type();
  if (type == fs::file_type::directory) {
    return kind == ResultKind::run && std::ranges::find(kFolders, place) != std::end(kFolders);
  }
  return type == fs::file_type::regular && std::regex_match(place, names_of(kind).files);
}

/// Calls visit(entry, place) for every entry of `dir` and of its folders that are ours, until it returns false.
/// `below`: the path of `dir` in the results folder, "" or "frames/". Returns false where `visit` did or an entry
/// cannot be read.
template <class Visit>
bool walk(const std::string& dir, const std::string& below, ResultKind kind, const Visit& visit) {
  std::error_code error;
  std::vector<fs::directory_entry> entries;
  for (fs::directory_iterator at(dir, error), end; !error && at != end; at.increment(error)) entries.push_back(*at);
  if (error) return false;
  std::ranges::sort(entries);
  for (const fs::directory_entry& entry : entries) {
    const std::string place = below + entry.path().filename().string();
    const bool folder = entry.symlink_status(error).type() == fs::file_type::directory;
    if (folder && is_ours(entry, place, kind) && !walk(entry.path().string(), place + "/", kind, visit)) return false;
    if (!visit(entry, place)) return false;
  }
  return true;
}

}  // namespace

std::optional<std::string> foreign_entry(const std::string& dir, ResultKind kind) {
  std::optional<std::string> found;
  const bool read = walk(dir, "", kind, [&](const fs::directory_entry& entry, const std::string& place) {
    if (!is_ours(entry, place, kind)) found = place;
    return !found;
  });
  if (!read && !found) return "something that cannot be read";
  return found;
}

bool is_marked(const std::string& dir, ResultKind kind) {
  return std::ranges::any_of(names_of(kind).marks, [&](const std::string& mark) {
    std::error_code error;
    return fs::is_regular_file(dir + "/" + mark, error);
  });
}

void remove_results(const std::string& dir, ResultKind kind) {
  std::error_code ignored;
  walk(dir, "", kind, [&](const fs::directory_entry& entry, const std::string& place) {
    if (is_ours(entry, place, kind)) fs::remove(entry.path(), ignored);  // a folder only once it is empty
    return true;
  });
  fs::remove(dir, ignored);
}

}  // namespace reamsim
