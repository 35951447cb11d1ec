#include "sim/study/collect.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>

#include "sim/base/csv.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/record/result_json.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Numbers = std::vector<std::pair<std::string, double>>;

constexpr std::size_t kMostSummaryBytes = 16'000'000;

/// Sections of summary.json that are not the same in every run of a scenario.
bool differs_from_run_to_run(const std::string& name) {
  return name == "timings_s" || name == "memory_mb";
}

void flatten(const Json& json, const std::string& name, Numbers& out) {
  if (json.is_number()) {
    out.emplace_back(name, json.get<double>());
  } else if (json.is_object()) {
    for (const auto& [key, value] : json.items()) {
      if (!name.empty() || !differs_from_run_to_run(key)) flatten(value, name.empty() ? key : name + "." + key, out);
    }
  } else if (json.is_array()) {
    for (std::size_t i = 0; i < json.size(); ++i) flatten(json[i], name + "." + std::to_string(i), out);
  }
}

/// The numbers of a finished run; none where its summary is damaged.
Numbers numbers_of(const std::string& run_dir) {
  Numbers out;
  const Json json = parse_result_json(read_file_start(run_dir + "/summary.json", kMostSummaryBytes));
  if (json.is_object()) flatten(json, "", out);
  return out;
}

/// The names of all numbers, each once; new ones follow those of the runs before.
class NumberColumns {
 public:
  void add(const Numbers& numbers) {
    for (const auto& [name, value] : numbers) {
      if (places_.emplace(name, names_.size()).second) names_.push_back(name);
    }
  }
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  [[nodiscard]] std::vector<std::string> cells(const Numbers& numbers) const {
    std::vector<std::string> out(names_.size());
    for (const auto& [name, value] : numbers) out[places_.at(name)] = shortest_text(value);
    return out;
  }

 private:
  std::map<std::string, std::size_t> places_;
  std::vector<std::string> names_;
};

const char* name_of(RunState state) {
  static const char* const names[] = {"missing", "interrupted", "failed", "done"};  // in the order of RunState
  return names[static_cast<std::size_t>(state)];
}

RunState state_of(const StudyFolder& folder, const IdentifiedRun& run) {
  return run.id.empty() ? RunState::failed : folder.state(run.id);
}

void count(RunState state, StudyCounts& counts) {
  switch (state) {
    case RunState::done:
      ++counts.done;
      return;
    case RunState::failed:
      ++counts.failed;
      return;
    case RunState::interrupted:
      ++counts.interrupted;
      return;
    case RunState::missing:
      ++counts.missing;
  }
}

std::string cell(const std::string& text) {
  return parse_number(text) ? text : csv_text(text);
}

void write_line(std::ofstream& out, const std::vector<std::string>& cells) {
  for (std::size_t i = 0; i < cells.size(); ++i) out << (i == 0 ? "" : ",") << cells[i];
  out << '\n';
}

}  // namespace

StudyCounts count_runs(const StudyFolder& folder, const std::vector<IdentifiedRun>& runs) {
  StudyCounts counts;
  for (const IdentifiedRun& run : runs) count(state_of(folder, run), counts);
  return counts;
}

StudyCounts collect_runs(const StudyFolder& folder, const StudyPlan& plan, const std::vector<IdentifiedRun>& runs) {
  NumberColumns columns;
  for (const IdentifiedRun& run : runs) {
    if (state_of(folder, run) == RunState::done) columns.add(numbers_of(folder.run_dir(run.id)));
  }
  const std::string path = folder.path() + "/runs.csv", unfinished = path + ".tmp";
  std::ofstream out(unfinished, std::ios::binary);
  std::vector<std::string> header{"run", "id", "status", "message"};
  for (const std::string& column : plan.columns) header.push_back(csv_text(column));
  header.insert(header.end(), columns.names().begin(), columns.names().end());
  write_line(out, header);
  StudyCounts counts;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const RunState state = state_of(folder, runs[i]);
    count(state, counts);
    std::string message = runs[i].mistake;
    if (message.empty() && state == RunState::failed) message = folder.failure(runs[i].id);
    std::vector<std::string> cells{std::to_string(plan.runs[i].number), runs[i].id, name_of(state), csv_text(message)};
    for (const std::string& text : plan.runs[i].cells) cells.push_back(cell(text));
    const Numbers numbers = state == RunState::done ? numbers_of(folder.run_dir(runs[i].id)) : Numbers();
    for (std::string& text : columns.cells(numbers)) cells.push_back(std::move(text));
    write_line(out, cells);
  }
  close_file(out, unfinished);
  sync_to_disk(unfinished);
  std::error_code error;
  fs::rename(unfinished, path, error);
  if (error) fail_to_write(path);
  return counts;
}

}  // namespace reamsim
