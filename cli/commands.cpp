#include "cli/commands.h"

#include <filesystem>

#include "sim/base/error.h"

namespace reamsim {

void make_folder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) throw InputError({path, 0, 0}, "--output", error.message(), "expected a folder that can be made");
}

}  // namespace reamsim
