// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/base/error.h"

namespace reamsim {

// Files that come with the program: reamers and scenarios. They are found from the place of the executable, or of the
// Python module, so that the build tree, an install prefix that was moved, and /usr work alike.

/// The folder `name` ("assets", "trajectories") of this program, or "".
std::string shipped_folder(const std::string& name);

enum class ShippedKind { scenario, study };

/// Names of the shipped scenarios or studies, in order: file names without ".yaml".
std::vector<std::string> shipped_names(ShippedKind kind);

/// Whether a path ends as that of a scenario: .yaml or .yml.
bool is_scenario_name(const std::string& path);

/// The file that an argument means. A word without slash and without ".yaml" that is no existing file or folder is the
/// name of a shipped scenario or study; anything else is a path and returned as it is. Throws InputError for an unknown
/// name, with the names there are, and for "default.yaml" where only the name without ending is known; without shipped
/// files such a word is a path as well.
std::string shipped_or_path(const std::string& argument, ShippedKind kind);

/// The same for an argument that may also be a bone: an unknown name is a path. Throws InputError for "default.yaml" as
/// well.
std::string shipped_scenario_or_path(const std::string& argument);

/// The same for the value of a key that names a scenario: a file of this name in `folder` is a path. An unknown name is
/// a mistake of the key, at `where`.
std::string shipped_scenario_of_key(const std::string& text, const std::string& folder, const SourceLocation& where,
                                    const std::string& key);

}  // namespace reamsim
