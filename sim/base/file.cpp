#include "sim/base/file.h"

#include <iterator>

#include "sim/base/error.h"

namespace reamsim {

std::string read_file(const std::string& path, const std::string& expected) {
  std::ifstream in(path, std::ios::binary);
  std::string content{std::istreambuf_iterator<char>(in), {}};
  if (content.empty()) throw InputError({path, 0, 0}, "", "cannot be read", expected);
  return content;
}

std::string read_file_start(const std::string& path, std::size_t most_bytes) {
  std::ifstream in(path, std::ios::binary);
  std::string start(most_bytes, '\0');
  in.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(in.gcount()));
  return start;
}

void write_file(const std::string& path, std::string_view content) {
  std::ofstream out(path, std::ios::binary);
  out.write(content.data(), static_cast<std::streamsize>(content.size()));
  close_file(out, path);
}

void close_file(std::ofstream& out, const std::string& path) {
  out.close();
  if (!out) fail_to_write(path);
}

void fail_to_write(const std::string& path) {
  throw RunError(path + ": cannot be written; is the disk full or the folder read-only?");
}

}  // namespace reamsim
