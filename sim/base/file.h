#pragma once

#include <fstream>
#include <string>
#include <string_view>

namespace reamsim {

/// The content of a file. `expected` says what it should be. Throws InputError when it cannot be read.
std::string read_file(const std::string& path, const std::string& expected);

/// The first `most_bytes` bytes of a file, or all of a shorter one; "" when it cannot be read.
std::string read_file_start(const std::string& path, std::size_t most_bytes);

/// Writes a file, replacing an older one. Throws RunError.
void write_file(const std::string& path, std::string_view content);

/// Closes `out`, which writes the file `path`. Throws RunError when anything could not be written.
void close_file(std::ofstream& out, const std::string& path);

/// Throws the RunError of a file that cannot be written.
[[noreturn]] void fail_to_write(const std::string& path);

}  // namespace reamsim
