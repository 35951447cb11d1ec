#pragma once

#include <string>

namespace reamsim {

// What the first scenarios of `init` and `preview` share.

/// The convex reamer that comes with the program: in the folder of the sources, or where it is installed; "" without
/// it.
std::string own_reamer();

/// A text in single quotes for YAML.
std::string yaml_quoted(const std::string& text);

}  // namespace reamsim
