// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <fstream>
#include <functional>
#include <string>
#include <string_view>

namespace reamsim {

/// Why the status of a path is unknown ("Permission denied"); "" if the path exists or does not exist.
std::string unreachable_reason(const std::string& path);

/// The content of a file. `expected` says what it should be. Throws InputError when it cannot be read.
std::string read_file(const std::string& path, const std::string& expected);

/// The first `most_bytes` bytes of a file, or all of a shorter one; "" when it cannot be read.
std::string read_file_start(const std::string& path, std::size_t most_bytes);

/// Writes a file, replacing an older one. Throws RunError.
void write_file(const std::string& path, std::string_view content);

/// As write_file(); the file has either the old or the new content, and the new one is on the disk on return. `check`
/// gets a file with the new content; where it throws, the old one stays.
void replace_file(const std::string& path, std::string_view content,
                  const std::function<void(const std::string& unfinished)>& check = {});

/// Shortens the file of a run to its `bytes` at a checkpoint, which are at least `head_bytes`. Throws InputError where
/// it is shorter, RunError.
void cut_to_checkpoint(const std::string& path, std::uintmax_t bytes, std::uintmax_t head_bytes = 0);

/// Waits until a file or the entries of a folder are on the disk. Throws RunError where they cannot be written.
void sync_to_disk(const std::string& path);
/// The same for a folder and everything below it. Links are not followed.
void sync_folder_to_disk(const std::string& dir);

/// Closes `out`, which writes the file `path`. Throws RunError when anything could not be written.
void close_file(std::ofstream& out, const std::string& path);

[[noreturn]] void fail_to_write(const std::string& path);

}  // namespace reamsim
