// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/scenario/key_tree.h"

namespace reamsim {

/// Expands ${VAR} from the environment ("$${" stands for "${"), and makes the path absolute: relative to `folder`.
/// An input must exist, be readable, and be a file where `kind` says so. "" stays "". Must be recordable.
/// Throws InputError with `where` and `key`.
std::string resolve_path(const std::string& text, TextKind kind, const std::string& folder, const SourceLocation& where,
                         const std::string& key);

/// Throws InputError with `where` and `key` unless the path can stand in YAML, JSON and metadata (is_printable()).
void require_recordable(const std::string& path, const SourceLocation& where, const std::string& key);

/// An absolute path as results hold it, so that resolve_path() gives it back: the user's home is ${HOME}, which keeps
/// the name of the user out of what is published; "${" is "$${".
std::string recorded_path(const std::string& path);

/// A message as results hold it: the user's home in it is ${HOME}.
std::string recorded_text(std::string text);

/// The text of a file, or of a pipe (`reamsim run <(command)`). Ends after more than `most_bytes`, so that a file
/// without an end is seen to be too large. Throws InputError, also for a pipe without text for ten seconds.
std::string read_scenario_text(const std::string& path, std::size_t most_bytes);

// Files that come with the program, found from the place of the executable or of the Python module.

/// The folder `name` ("assets", "trajectories") of this program, or "".
std::string shipped_folder(const std::string& name);

enum class ShippedKind { scenario, study };
template <>
inline constexpr auto kChoiceNames<ShippedKind> = name_list("scenario", "study");

/// Names of the shipped scenarios or studies, in order: file names without ".yaml"; "validation/NAME" of a study with
/// published numbers, NAME.csv, beside it.
std::vector<std::string> shipped_names(ShippedKind kind);

/// Whether a path ends as that of a scenario: .yaml or .yml.
bool is_scenario_name(const std::string& path);

/// The file that an argument means. A word without slash and without ".yaml" that is no existing file or folder is the
/// name of a shipped scenario or study, and so is "validation/NAME" of one; anything else is a path and returned as it
/// is, and so is such a word without shipped files. Throws InputError for an unknown name, with the names there are,
/// and for "default.yaml" where only the name without ending is known.
std::string shipped_or_path(const std::string& argument, ShippedKind kind);

/// The same for an argument that may also be a bone: an unknown name is a path.
std::string shipped_scenario_or_path(const std::string& argument);

/// The same for the value of a key: a file of this name in `folder` is a path, an unknown name a mistake of the key.
std::string shipped_scenario_of_key(const std::string& text, const std::string& folder, const SourceLocation& where,
                                    const std::string& key);

}  // namespace reamsim
