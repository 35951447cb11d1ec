#include "cli/first_scenario.h"

#include <filesystem>

namespace reamsim {

namespace fs = std::filesystem;

std::string own_reamer() {
  std::error_code ignored;
  const fs::path folder = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  for (const char* assets : {"../share/reamsim/assets", "../../../assets", "assets"}) {
    const fs::path path = (folder / assets / "reamer_convex.stl").lexically_normal();
    if (fs::exists(path, ignored)) return path.string();
  }
  return "";
}

std::string yaml_quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? "''" : std::string(1, c);
  return out + "'";
}

}  // namespace reamsim
