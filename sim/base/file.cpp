// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/base/file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <iterator>
#include <system_error>

#include "sim/base/error.h"

namespace reamsim {

std::string unreachable_reason(const std::string& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  return error && status.type() != std::filesystem::file_type::not_found ? error.message() : "";
}

std::string read_file(const std::string& path, const std::string& expected) {
  std::ifstream in(path, std::ios::binary);
  std::string content;
  try {
    content.assign(std::istreambuf_iterator<char>(in), {});
  } catch (const std::ios_base::failure&) {  // a folder can be opened, but not read; or the disk fails
    content.clear();
  }
  if (content.empty()) refuse_file(path, "cannot be read", expected);
  return content;
}

std::string read_file_start(const std::string& path, std::size_t most_bytes) {
  std::ifstream in(path, std::ios::binary);
  constexpr std::size_t kFirstBytes = 4096;
  std::string start;
  // Doubles, so that a limit far beyond the file costs no memory.
  for (std::size_t end = std::min(most_bytes, kFirstBytes); start.size() < end; end = std::min(most_bytes, 2 * end)) {
    const std::size_t before = start.size();
    start.resize(end);
    in.read(start.data() + before, static_cast<std::streamsize>(end - before));
    start.resize(before + static_cast<std::size_t>(in.gcount()));
    if (start.size() < end) break;
  }
  return start;
}

void write_file(const std::string& path, std::string_view content) {
  std::ofstream out(path, std::ios::binary);
  out.write(content.data(), static_cast<std::streamsize>(content.size()));
  close_file(out, path);
}

void replace_file(const std::string& path, std::string_view content,
                  const std::function<void(const std::string& unfinished)>& check) {
  const std::string unfinished = path + ".tmp";
  std::error_code error;
  try {
    write_file(unfinished, content);
    if (check) check(unfinished);
    sync_to_disk(unfinished);
    std::filesystem::rename(unfinished, path, error);
    if (error) fail_to_write(path);
  } catch (...) {
    std::filesystem::remove(unfinished, error);
    throw;
  }
  sync_to_disk(std::filesystem::absolute(path).parent_path().string());
}

void cut_to_checkpoint(const std::string& path, std::uintmax_t bytes, std::uintmax_t head_bytes) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error || size < bytes || bytes < head_bytes) {
    refuse_file(path, "is shorter than when the checkpoint was written", "start again with --overwrite");
  }
  std::filesystem::resize_file(path, bytes, error);
  if (error) fail_to_write(path);
}

void sync_to_disk(const std::string& path) {
  const int opened = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  // EINVAL, ENOSYS: a file system that cannot be asked.
  const bool synced = opened >= 0 && (fsync(opened) == 0 || errno == EINVAL || errno == ENOSYS);
  if (opened >= 0) close(opened);
  if (!synced) fail_to_write(path);
}

void sync_folder_to_disk(const std::string& dir) {
  for (const auto& entry : std::filesystem::recursive_directory_iterator(dir)) {
    const bool link = entry.is_symlink();
    if (!link && (entry.is_regular_file() || entry.is_directory())) sync_to_disk(entry.path().string());
  }
  sync_to_disk(dir);
}

void close_file(std::ofstream& out, const std::string& path) {
  out.close();
  if (!out) fail_to_write(path);
}

void fail_to_write(const std::string& path) {
  throw RunError(path + ": cannot be written; is the disk full or the folder read-only?");
}

}  // namespace reamsim
