// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/text_file.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>

#include "sim/base/error.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

constexpr int kPipeWait_ms = 10'000;

[[noreturn]] void refuse(const std::string& path, const std::string& found) {
  throw InputError({shown_path(path), 0, 0}, "", found, "expected a scenario file (YAML)");
}

[[noreturn]] void refuse_with_reason(const std::string& path, int error) {
  refuse(path, "cannot be read (" + std::generic_category().message(error) + ")");
}

/// A descriptor of the file.
int open_to_read(const std::string& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // or it would wait for a pipe's writer
  if (file >= 0) return file;
  if (errno == ENOENT || errno == ENOTDIR) refuse(path, "no such file");
  refuse_with_reason(path, errno);
}

/// A file that is open for reading.
class OpenFile {
 public:
  explicit OpenFile(const std::string& path) : path_(path), file_(open_to_read(path)) {
    struct stat status {};
    is_pipe_ = fstat(file_, &status) == 0 && S_ISFIFO(status.st_mode);
  }
  ~OpenFile() { close(file_); }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  /// Reads into `text`; false at the end of the file.
  bool read_on(std::string& text) const {
    std::array<char, 65536> chunk{};
    wait_for_text();
    const ssize_t count = read(file_, chunk.data(), chunk.size());
    if (count < 0 && errno == EISDIR) refuse(path_, "is a folder");
    if (count < 0 && errno != EAGAIN && errno != EINTR) refuse_with_reason(path_, errno);
    if (count > 0) text.append(chunk.data(), static_cast<std::size_t>(count));
    return count != 0;
  }

 private:
  /// A pipe has an end only after a writer has opened it, which poll() waits for and read() does not.
  void wait_for_text() const {
    pollfd input{.fd = file_, .events = POLLIN, .revents = 0};
    if (poll(&input, 1, is_pipe_ ? kPipeWait_ms : -1) == 0)
      refuse(path_, "is a pipe into which nothing was written for 10 s");
  }

  const std::string& path_;
  int file_;
  bool is_pipe_ = false;
};

}  // namespace

std::string read_scenario_text(const std::string& path, std::size_t most_bytes) {
  const OpenFile file(path);
  std::string text;
  while (text.size() <= most_bytes && file.read_on(text)) {
  }
  return text;
}

}  // namespace reamsim
