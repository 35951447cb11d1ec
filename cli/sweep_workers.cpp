// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/sweep.h"

#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <memory>
#include <optional>

#include "cli/stop.h"
#include "sim/base/error.h"
#include "sim/base/process.h"

namespace reamsim {

namespace {

constexpr int kPoll_ms = 100;
/// How often in a row a worker may end before it has finished a run.
constexpr int kMostDeaths = 20;

/// How a process ended, in words.
std::string cause_of(int status) {
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    const std::string hint = signal == SIGKILL ? "; the system may have run out of memory: use fewer --jobs" : "";
    return std::string("its process was ended by signal ") + std::to_string(signal) + " (" + strsignal(signal) + ")" +
           hint;
  }
  return "its process ended with status " + std::to_string(WEXITSTATUS(status));
}

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
  /// Waits for its end and says why it ended.
  std::string end() {
    const int status = wait_for(pid_);
    pid_ = -1;
    return cause_of(status);
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
  Parts(const std::vector<std::size_t>& runs, std::size_t workers) : parts_(workers) {
    for (std::size_t i = 0; i < runs.size(); ++i) parts_[i * workers / runs.size()].push_back(runs[i]);
  }

  std::optional<std::size_t> next(std::size_t worker) {
    std::deque<std::size_t>& own = parts_[worker];
    if (own.empty()) {
      auto& longest = *std::ranges::max_element(parts_, {}, &std::deque<std::size_t>::size);
      for (std::size_t half = (longest.size() + 1) / 2; half > 0; --half) {
        own.push_front(longest.back());
        longest.pop_back();
      }
    }
    if (own.empty()) return std::nullopt;
    const std::size_t run = own.front();
    own.pop_front();
    return run;
  }

 private:
  std::vector<std::deque<std::size_t>> parts_;
};

class Work {
 public:
  Work(std::vector<std::vector<std::string>> commands, const SweepRuns& sweep, const std::vector<std::size_t>& runs,
       const std::function<void(const WorkerAnswer&)>& answered)
      : commands_(std::move(commands)), sweep_(sweep), parts_(runs, commands_.size()), answered_(answered) {
    workers_.resize(commands_.size());
  }

  bool run() {
    for (std::size_t i = 0; i < workers_.size(); ++i) begin_next(i);
    const StopGrace until_saved;
    while (wait_for_answers()) {
      if (!stopping_ && stop_requested()) stop();
    }
    return !stopping_;
  }

 private:
  void stop() {
    stopping_ = true;
    for (const auto& worker : workers_) {
      if (worker) worker->stop();
    }
  }

  void begin_next(std::size_t i) {
    const auto run = stopping_ ? std::nullopt : parts_.next(i);
    if (!run) {
      workers_[i].reset();
      return;
    }
    if (!workers_[i]) workers_[i] = std::make_unique<Worker>(commands_[i]);
    workers_[i]->begin(*run, sweep_.runs[*run].id);
  }

  /// Handles what workers say for a moment. Returns false once none is left.
  bool wait_for_answers() {
    std::vector<pollfd> polled;
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < workers_.size(); ++i) {
      if (!workers_[i]) continue;
      polled.push_back({workers_[i]->answers(), POLLIN, 0});
      places.push_back(i);
    }
    if (polled.empty()) return false;
    if (poll(polled.data(), polled.size(), kPoll_ms) <= 0) return true;
    for (std::size_t p = 0; p < polled.size(); ++p) {
      if (polled[p].revents != 0) hear(places[p]);
    }
    return true;
  }

  void hear(std::size_t i) {
    if (!workers_[i]->read_more()) return replace(i);
    if (const auto answer = workers_[i]->take_answer()) {
      deaths_ = 0;
      answered_(*answer);
      begin_next(i);
    }
  }

  /// A worker has ended. Its run has failed, unless it was asked to stop.
  void replace(std::size_t i) {
    const auto run = workers_[i]->run();
    const std::string cause = workers_[i]->end();
    workers_[i].reset();
    if (!run) return;
    using Outcome = WorkerAnswer::Outcome;
    const bool asked_to = stopping_ || stop_requested();
    answered_({.run = *run, .outcome = asked_to ? Outcome::interrupted : Outcome::failed, .text = cause});
    if (!asked_to && ++deaths_ >= kMostDeaths) {
      throw RunError("workers end before they finish a run: " + cause);
    }
    begin_next(i);
  }

  std::vector<std::vector<std::string>> commands_;
  const SweepRuns& sweep_;
  Parts parts_;
  const std::function<void(const WorkerAnswer&)>& answered_;
  std::vector<std::unique_ptr<Worker>> workers_;
  bool stopping_ = false;
  int deaths_ = 0;
};

/// Workers share the processors: PoCL of each uses its part only, and does not pin its threads to the first ones.
void divide_processors(int jobs) {
  const long processors = std::max(1L, sysconf(_SC_NPROCESSORS_ONLN));
  setenv("POCL_AFFINITY", "0", 1);
  setenv("POCL_MAX_PTHREAD_COUNT", std::to_string(std::max(1L, processors / jobs)).c_str(), 0);
}

}  // namespace

bool work_on(const SweepRuns& sweep, const std::vector<std::size_t>& runs, const SweepOptions& options,
             const std::string& dir, int jobs, const std::function<void(const WorkerAnswer&)>& answered) {
  if (runs.empty()) return true;
  jobs = std::min(jobs, static_cast<int>(runs.size()));
  if (jobs > 1) divide_processors(jobs);
  std::vector<std::vector<std::string>> commands;
  for (int i = 0; i < jobs; ++i) {
    std::vector<std::string> command{"/proc/self/exe", "sweep", "worker", options.file};
    if (!dir.empty()) command.insert(command.end(), {"-o", dir});
    for (const std::string& text : options.overrides) command.insert(command.end(), {"--set", text});
    command.insert(command.end(), {"--part", std::to_string(i) + "/" + std::to_string(jobs)});
    commands.push_back(std::move(command));
  }
  return Work(std::move(commands), sweep, runs, answered).run();
}

}  // namespace reamsim
