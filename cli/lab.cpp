// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/lab.h"

#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstring>
#include <thread>

#include "sim/base/error.h"
#include "sim/base/process.h"
#include "sim/base/text.h"
#include "sim/record/force_log.h"
#include "sim/scenario/paths.h"

namespace reamsim {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSystemPython = "/usr/bin/python3";

std::string python() {
  const char* const named = std::getenv("REAMSIM_PYTHON");
  if (named != nullptr && *named != '\0') return named;
  return access(kSystemPython, X_OK) == 0 ? kSystemPython : "python3";
}

/// The package of this program, whatever the user has installed for Python (-I); without it, that which Python finds.
std::vector<std::string> python_with_package() {
  const std::string package = shipped_folder("python/src");
  if (package.empty()) return {python(), "-B", "-m", "reamsim.lab"};
  return {python(), "-I", "-B", package + "/reamsim/lab/__main__.py"};
}

/// waitpid()'s status. A stop of this command ends the process first, and throws Interrupted.
int wait_or_stop(pid_t child) {
  using namespace std::chrono_literals;
  int status = 0;
  while (waitpid(child, &status, WNOHANG) == 0) {
    if (stop_requested()) {
      kill(child, SIGTERM);
      wait_for(child);
      throw Interrupted();
    }
    std::this_thread::sleep_for(5ms);
  }
  if (stop_requested()) throw Interrupted();  // Ctrl-C in a terminal reaches it as well
  return status;
}

std::string last_line(std::string text) {
  while (text.ends_with('\n')) text.pop_back();
  return text.empty() ? "no message" : text.substr(text.find_last_of('\n') + 1);
}

/// Makes a text the content of a file in memory, for a process that reads it from the start. Throws RunError.
void fill(const MemoryFile& file, std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const ssize_t written = pwrite(file.descriptor(), text.data() + at, text.size() - at, static_cast<off_t>(at));
    if (written < 0 && errno != EINTR)
      throw RunError(std::string("no memory for the statistics: ") + std::strerror(errno));
    if (written > 0) at += static_cast<std::size_t>(written);
  }
}

}  // namespace

Json call_lab(const std::string& command, const std::vector<std::string>& paths, const Json& job) {
  constexpr int kWrongInput = 2;
  MemoryFile in("the statistics"), out("the statistics"), err("the messages of Python");
  fill(in, job.dump());
  ChildCommand call{
      .arguments = python_with_package(), .in = in.descriptor(), .out = out.descriptor(), .err = err.descriptor()};
  call.arguments.push_back(command);
  call.arguments.insert(call.arguments.end(), paths.begin(), paths.end());
  pid_t child = 0;
  if (const int error = spawn(call, child); error != 0) {
    throw RunError(python() + " cannot be started: " + std::strerror(error) +
                   "; the statistics need Python 3; install it: apt install python3-scipy python3-matplotlib "
                   "python3-yaml; or set REAMSIM_PYTHON to the path of another");
  }
  const int status = wait_or_stop(child);
  const Json answer = Json::parse(out.contents(), nullptr, false);
  if (!answer.is_object()) throw RunError("the statistics failed: " + python() + ": " + last_line(err.contents()));
  if (succeeded(status)) return answer;
  const std::string message = answer.value("error", "no message");
  if (WIFEXITED(status) && WEXITSTATUS(status) == kWrongInput) {
    std::vector<Mistake> mistakes;
    for (const std::string& line : split(message, '\n'))
      mistakes.push_back({.where = {}, .key = "", .found = line, .expected = ""});
    throw InputError(std::move(mistakes));
  }
  throw RunError(message);
}

void require_lab() {
  call_lab("check", {}, Json::object());
}

void say_answer(const Json& answer, const Console& console) {
  for (const Json& line : answer.value("say", Json::array())) console.say(line.get<std::string>());
  for (const Json& line : answer.value("warn", Json::array())) console.warn(line.get<std::string>());
}

Json law_json(const LawSettings& law) {
  const CuttingSettings& cutting = law.cutting;
  Json out{{"cutting.specific_energy_j_mm3", cutting.specific_energy_j_mm3},
           {"cutting.reference_density_g_cm3", cutting.reference_density_g_cm3},
           {"cutting.density_exponent", cutting.density_exponent},
           {"cutting.normal_ratio", cutting.normal_ratio},
           {"bone.density.ash_slope_g_cm3_per_hu", law.density.ash_slope_g_cm3_per_hu},
           {"bone.density.ash_offset_g_cm3", law.density.ash_offset_g_cm3},
           {"bone.density.ash_fraction", law.density.ash_fraction}};
  for (const SpecificEnergySettings& row : cutting.specific_energy_table) {
    out["cutting.specific_energy_table"].push_back(
        {{"density_g_cm3", row.density_g_cm3}, {"energy_j_mm3", row.energy_j_mm3}});
  }
  if (const auto& edge = cutting.edge_force) {
    out["cutting.edge_force.tangential_n_mm"] = edge->tangential_n_mm;
    out["cutting.edge_force.normal_n_mm"] = edge->normal_n_mm;
  }
  return out;
}

void require_readable_log(const std::string& run_dir) {
  for_each_result(run_dir + "/forces.csv", {}, [](const FrameResult&) {});
}

}  // namespace reamsim
