// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "cli/console.h"
#include "cli/environment.h"
#include "cli/outputs.h"
#include "cli/sweep.h"
#include "sim/base/error.h"
#include "sim/base/process.h"
#include "sim/base/text.h"
#include "sim/record/output_folder.h"
#include "sim/study/study_folder.h"

namespace reamsim {

namespace {

constexpr int kPoll_ms = 100;
/// How often in a row a worker may end before it has finished a run.
constexpr int kMostDeaths = 20;
/// How often in a row a device of --devices may fail.
constexpr int kMostDeviceFailures = 3;

/// A process that works on one run at a time.
class Worker {
 public:
  explicit Worker(const std::vector<std::string>& command) {
    int ends[2];  // programs that this one starts do not inherit them
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
      throw RunError(std::string("no connection to a worker: ") + std::strerror(errno));
    }
    socket_ = ends[0];
    const int error = spawn({.arguments = command, .in = ends[1], .out = ends[1], .own_group = true}, pid_);
    close(ends[1]);
    if (error != 0) {
      close(socket_);
      throw RunError(std::string("no worker can be started: ") + std::strerror(error));
    }
  }
  ~Worker() {
    shutdown(socket_, SHUT_WR);  // ends it
    if (pid_ > 0) wait_for(pid_);
    close(socket_);
  }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// Gives it a run, named by index and folder.
  void begin(std::size_t run, const std::string& id) {
    run_ = run;
    const std::string line = std::to_string(run) + " " + id + "\n";
    // Where it has ended, end of file says so.
    if (write(socket_, line.data(), line.size()) < 0) return;
  }
  [[nodiscard]] const std::optional<std::size_t>& run() const { return run_; }
  [[nodiscard]] int answers() const { return socket_; }

  /// Reads what has come. Returns false at the end of file.
  bool read_more() {
    char buffer[4096];
    const ssize_t got = read(socket_, buffer, sizeof buffer);
    if (got > 0) text_.append(buffer, static_cast<std::size_t>(got));
    return got > 0;
  }
  /// The next whole answer.
  std::optional<WorkerAnswer> take_answer() {
    const std::size_t end = text_.find('\n');
    if (end == std::string::npos || !run_) return std::nullopt;
    WorkerAnswer answer{
        .run = *run_, .outcome = static_cast<WorkerAnswer::Outcome>(text_[0]), .text = text_.substr(2, end - 2)};
    text_.erase(0, end + 1);
    run_.reset();
    return answer;
  }
  void stop() const { kill(pid_, SIGTERM); }
  /// Ends it at once: a driver that has lost its device may not let it end by itself.
  void end_now() const { kill(pid_, SIGKILL); }
  /// Waits for its end and says why it ended.
  std::string end() {
    const int status = wait_for(std::exchange(pid_, -1));
    if (!WIFSIGNALED(status)) return fmt::format("its process ended with status {}", WEXITSTATUS(status));
    const int signal = WTERMSIG(status);
    return fmt::format("its process was ended by signal {} ({}){}", signal, strsignal(signal),
                       signal == SIGKILL ? "; the system may have run out of memory: use fewer --jobs" : "");
  }

 private:
  int socket_ = -1;
  pid_t pid_ = -1;
  std::optional<std::size_t> run_;
  std::string text_;
};

/// Gives each worker a contiguous part of the runs, so that neighbours with the same bone stay together; a worker that
/// has finished its part takes over half of the longest one that is left.
class Parts {
 public:
  Parts(std::span<const std::size_t> runs, std::size_t workers) {
    const auto begin = [&](std::size_t part) { return (part * runs.size() + workers - 1) / workers; };
    for (std::size_t i = 0; i < workers; ++i) parts_.push_back(runs.subspan(begin(i), begin(i + 1) - begin(i)));
  }

  std::optional<std::size_t> next(std::size_t worker) {
    std::span<const std::size_t>& own = parts_[worker];
    if (own.empty()) {
      auto& longest = *std::ranges::max_element(parts_, {}, &std::span<const std::size_t>::size);
      own = longest.subspan(longest.size() / 2);
      longest = longest.first(longest.size() - own.size());
    }
    if (own.empty()) return std::nullopt;
    const std::size_t run = own.front();
    own = own.subspan(1);
    return run;
  }

 private:
  std::vector<std::span<const std::size_t>> parts_;
};

class Work {
 public:
  /// `command`: of a worker, without what differs between workers.
  Work(std::vector<std::string> command, const std::vector<std::string>& devices, const SweepRuns& sweep,
       std::span<const std::size_t> runs, std::size_t workers, const std::function<void(const WorkerAnswer&)>& answered)
      : command_(std::move(command)),
        devices_(devices),
        sweep_(sweep),
        parts_(runs, workers),
        answered_(answered),
        workers_(workers),
        device_failures_(std::max<std::size_t>(1, devices.size())) {}

  bool run() {
    for (std::size_t i = 0; i < workers_.size(); ++i) begin_next(i);
    const auto until_saved = stop_grace();
    while (wait_for_answers()) {
      if (stopping_ || !stop_requested()) continue;
      stopping_ = true;
      for (const auto& worker : workers_) {
        if (worker) worker->stop();
      }
    }
    for (auto left = parts_.next(0); left && !stopping_; left = parts_.next(0)) {
      answered_({.run = *left, .outcome = Outcome::device_failed, .text = "no device is left; " + device_failure_});
    }
    return !stopping_;
  }

 private:
  using Outcome = WorkerAnswer::Outcome;

  void begin_next(std::size_t i) {
    const auto run = stopping_ || is_lost(i) ? std::nullopt : parts_.next(i);
    if (!run) return workers_[i].reset();
    if (!workers_[i]) workers_[i] = std::make_unique<Worker>(command_of(i));
    workers_[i]->begin(*run, sweep_.runs[*run].id);
  }

  [[nodiscard]] std::vector<std::string> command_of(std::size_t i) const {
    std::vector<std::string> out = command_;
    out.insert(out.end(), {"--part", std::to_string(i), std::to_string(workers_.size())});
    if (!devices_.empty()) out.insert(out.end(), {"--devices", devices_[device_of(i)]});
    return out;
  }

  /// Handles what workers say for a moment. Returns false once none is left.
  bool wait_for_answers() {
    std::vector<pollfd> polled;  // poll() skips those without a worker
    for (const auto& worker : workers_) polled.push_back({worker ? worker->answers() : -1, POLLIN, 0});
    if (std::ranges::none_of(workers_, [](const auto& worker) { return worker != nullptr; })) return false;
    if (poll(polled.data(), polled.size(), kPoll_ms) <= 0) return true;
    for (std::size_t i = 0; i < polled.size(); ++i) {
      if (polled[i].revents != 0) hear(i);
    }
    return true;
  }

  void hear(std::size_t i) {
    if (!workers_[i]->read_more()) return replace(i);
    if (const auto answer = workers_[i]->take_answer()) {
      deaths_ = 0;
      answered_(*answer);
      if (answer->outcome == Outcome::done) device_failures_[device_of(i)] = 0;
      if (answer->outcome == Outcome::device_failed) {
        workers_[i]->end_now();  // the driver gets a new process
        workers_[i].reset();
        count_failure(i, answer->text);
      }
      begin_next(i);
    }
  }

  /// A worker has ended. Its run has failed, unless it was asked to stop.
  void replace(std::size_t i) {
    const auto run = workers_[i]->run();
    const std::string cause = workers_[i]->end();
    workers_[i].reset();
    if (!run) return;
    const bool asked_to = stopping_ || stop_requested();
    answered_({.run = *run, .outcome = asked_to ? Outcome::interrupted : Outcome::failed, .text = cause});
    if (!asked_to && ++deaths_ >= kMostDeaths) throw RunError("workers end before they finish a run: " + cause);
    count_failure(i, cause);
    begin_next(i);
  }

  [[nodiscard]] std::size_t device_of(std::size_t worker) const { return worker % device_failures_.size(); }
  void count_failure(std::size_t worker, const std::string& cause) {
    ++device_failures_[device_of(worker)];
    device_failure_ = cause;
  }
  /// Whether the device of --devices fails again and again, so that others take its runs.
  [[nodiscard]] bool is_lost(std::size_t worker) const {
    return !devices_.empty() && device_failures_[device_of(worker)] >= kMostDeviceFailures;
  }

  std::vector<std::string> command_;
  const std::vector<std::string>& devices_;  ///< of --devices; none: engine.device
  const SweepRuns& sweep_;
  Parts parts_;
  const std::function<void(const WorkerAnswer&)>& answered_;
  std::vector<std::unique_ptr<Worker>> workers_;
  std::vector<int> device_failures_;  ///< in a row, by device: worker i has device i modulo their number
  std::string device_failure_;        ///< the last one
  bool stopping_ = false;
  int deaths_ = 0;
};

/// Leaves this process part `index` of `count` of the processors it may use.
void take_processors(int index, int count) {
  if (count < 2) return;
  cpu_set_t all, own;
  if (sched_getaffinity(0, sizeof all, &all) != 0) return;
  CPU_ZERO(&own);
  const int processors = CPU_COUNT(&all);
  for (int cpu = 0, k = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(cpu, &all) == 0) continue;
    if (k * count / processors == index || (processors < count && k == index % processors)) CPU_SET(cpu, &own);
    ++k;
  }
  if (CPU_COUNT(&own) > 0) sched_setaffinity(0, sizeof own, &own);
}

/// Works on runs from standard input ("INDEX ID"), and answers each with a line on standard output (WorkerAnswer).
class RunWorker {
 public:
  /// Without the study's folder it only checks.
  explicit RunWorker(const SweepOptions& options)
      : study_(read_study(options.file)),
        plan_(make_plan(study_, options.overrides)),
        device_(options.devices.empty() ? "" : options.devices.front()) {
    if (!options.output.empty()) folder_ = StudyFolder::open(study_, options.output);
    console_.quiet = true;
    resources_.bones = &bones_;
  }

  void work() {
    std::size_t run = 0;
    std::string id;
    while (!stop_requested() && std::cin >> run >> id) {
      const auto [outcome, text] = outcome_of(run, id);
      std::printf("%c %s\n", static_cast<char>(outcome), printable(text).c_str());
      std::fflush(stdout);
    }
  }

 private:
  using Outcome = WorkerAnswer::Outcome;

  std::pair<Outcome, std::string> outcome_of(std::size_t run, const std::string& id) {
    try {
      return {Outcome::done, done(run, id)};
    } catch (const FolderInUse& error) {
      return {Outcome::busy, message_of(error)};
    } catch (const Interrupted& error) {
      return {Outcome::interrupted, message_of(error)};
    } catch (const InputError& error) {
      // The command has found the device of --devices when it began.
      const Mistake& first = error.mistakes().front();
      const bool is_gone = !device_.empty() && first.key == "engine.device" && first.where.file.empty();
      return {is_gone ? Outcome::device_failed : Outcome::wrong_input, message_of(error)};
    } catch (const cl::DeviceError& error) {
      return {Outcome::device_failed, message_of(error)};
    } catch (const std::exception& error) {
      return {Outcome::failed, message_of(error)};
    }
  }

  std::string done(std::size_t run, const std::string& id) {
    if (run >= plan_.runs.size()) throw RunError("the study has changed while it was running; run it again");
    RunRequest request;
    request.scenario = scenario_of(study_, plan_.runs[run]);
    if (run_id(request.scenario, study_.keep, checksums_) != id) {
      throw RunError("the study or one of its files has changed while it was running; run it again");
    }
    if (!device_.empty()) request.scenario.engine.device = device_;
    if (!kernels_) kernels_ = prepare_opencl(request.scenario.engine.device, console_);
    if (!folder_) {
      const nlohmann::json estimate = estimator_.estimate(request.scenario, resources_);
      return estimate.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    }
    request.dir = folder_->run_dir(id);
    request.overwrite = true;
    request.resume = true;
    request.keep = study_.keep;
    request.durable = false;
    RunConsole monitor(console_);
    Outputs pictures(console_, false);
    const auto continued_after = run_scenario(request, resources_, monitor, &pictures);
    return continued_after ? "continued after frame " + std::to_string(*continued_after) : "";
  }

  Study study_;
  StudyPlan plan_;
  std::string device_;                 ///< in place of that of the scenarios; "": none
  std::optional<StudyFolder> folder_;  ///< not where it only checks
  Console console_;
  Checksums checksums_;
  BoneCache bones_;
  std::unique_ptr<cl::KernelCache> kernels_;  // before the devices
  RunResources resources_;
  RunEstimator estimator_;
};

}  // namespace

bool work_on(const SweepRuns& sweep, const std::vector<std::size_t>& runs, const SweepOptions& options,
             const std::string& dir, const Console& console, const std::function<void(const WorkerAnswer&)>& answered) {
  if (runs.empty()) return true;
  const int jobs = std::min(options.workers(), static_cast<int>(runs.size()));
  if (jobs > 1) {
    // Workers share the processors: PoCL of each uses its part only, and does not pin its threads to the first ones.
    const long processors = std::max(1L, sysconf(_SC_NPROCESSORS_ONLN));
    setenv("POCL_AFFINITY", "0", 1);
    setenv("POCL_MAX_PTHREAD_COUNT", std::to_string(std::max(1L, processors / jobs)).c_str(), 0);
  }
  std::vector<std::string> command{"/proc/self/exe", "sweep", "worker", options.file};
  if (!dir.empty()) command.insert(command.end(), {"-o", dir});
  for (const std::string& text : options.overrides) command.insert(command.end(), {"--set", text});
  Progress progress(console, dir.empty() ? "check" : "sweep", "runs");
  std::int64_t count = 0;
  const auto counted = [&](const WorkerAnswer& answer) {
    answered(answer);
    progress.update(++count, std::ssize(runs));
  };
  return Work(std::move(command), options.devices, sweep, runs, static_cast<std::size_t>(jobs), counted).run();
}

void add_sweep_worker(CLI::App& sweep) {
  auto* command = sweep.add_subcommand("worker", "")->group("");  // not listed: only work_on() starts it
  auto options = std::make_shared<SweepOptions>();
  auto part = std::make_shared<std::pair<int, int>>(0, 1);
  options->add_to(*command);
  command->add_option("--part", *part);
  command->add_option("--devices", options->devices);
  command->callback([options, part] {
    prctl(PR_SET_PDEATHSIG, SIGTERM);  // where the command that gives it runs is killed
    prctl(PR_SET_NAME, "reamsim");     // it was started by way of /proc/self/exe, and would be listed as "exe"
    take_processors(part->first, part->second);
    RunWorker(*options).work();
  });
}

}  // namespace reamsim
