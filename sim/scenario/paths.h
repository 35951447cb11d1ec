// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <string>

#include "sim/base/error.h"
#include "sim/scenario/key_visitor.h"

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

/// The text of a scenario: of a file, or of a pipe (`reamsim run <(command)`). Ends after more than `most_bytes`, so
/// that a file without an end is seen to be too large. Throws InputError, also for a pipe into which nothing is written
/// for ten seconds.
std::string read_scenario_text(const std::string& path, std::size_t most_bytes);

}  // namespace reamsim
