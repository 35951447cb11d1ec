#include "render/plots/plots.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "sim/base/error.h"

namespace reamsim {

namespace {

/// A pipe whose ends close themselves.
class Pipe {
 public:
  Pipe() {
    if (pipe2(ends_.data(), O_CLOEXEC) != 0) throw RunError("no pipe to gnuplot: " + std::string(std::strerror(errno)));
  }
  ~Pipe() {
    close_end(0);
    close_end(1);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  [[nodiscard]] int write_end() const { return ends_[1]; }
  void close_write() { close_end(1); }

  /// All that comes until every writer has closed its end.
  [[nodiscard]] std::string read_all() const {
    std::string text;
    std::array<char, 4096> buffer;
    for (;;) {
      const ssize_t got = read(ends_[0], buffer.data(), buffer.size());
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return text;
      text.append(buffer.data(), static_cast<std::size_t>(got));
    }
  }

 private:
  void close_end(std::size_t end) {
    if (ends_[end] >= 0) close(ends_[end]);
    ends_[end] = -1;
  }

  std::array<int, 2> ends_{-1, -1};
};

/// Runs `gnuplot -d SCRIPT` in `dir`; its words on stderr come back in `words`. Returns what waitpid() gives.
int spawn_gnuplot(const std::string& dir, std::string script, std::string& words) {
  Pipe pipe;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, dir.c_str());
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, pipe.write_end(), STDERR_FILENO);
  std::string program = "gnuplot";
  std::string plain = "-d";  // without the user's own settings, which could change the figures
  std::array<char*, 4> arguments{program.data(), plain.data(), script.data(), nullptr};
  pid_t child = 0;
  const int error = posix_spawnp(&child, "gnuplot", &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw RunError(std::string("gnuplot cannot be started: ") + std::strerror(error));
  pipe.close_write();
  words = pipe.read_all();
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

std::string on_one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  const std::size_t first = text.find_first_not_of(' ');
  const std::size_t last = text.find_last_not_of(' ');
  return first == std::string::npos ? std::string("no message") : text.substr(first, last - first + 1);
}

}  // namespace

std::string gnuplot_string(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'') out += '\'';
    out += static_cast<unsigned char>(c) < ' ' || c == 0x7f ? ' ' : c;
  }
  return out + "'";
}

void run_gnuplot(const std::string& dir, const std::string& script, const std::string& text,
                 const std::vector<std::string>& pictures) {
  const std::string script_path = dir + "/" + script;
  std::ofstream out(script_path, std::ios::binary);
  out << text;
  out.close();
  if (!out) throw RunError(script_path + ": cannot be written; is the disk full or the folder read-only?");
  std::string words;
  const int status = spawn_gnuplot(dir, script, words);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw RunError(dir + ": gnuplot failed on " + script + ": " + on_one_line(words));
  }
  for (const std::string& name : pictures) {
    std::error_code error;
    if (std::filesystem::file_size(dir + "/" + name, error) == 0 || error) {
      throw RunError(dir + "/" + name + ": gnuplot wrote nothing: " + on_one_line(words));
    }
  }
}

}  // namespace reamsim
