// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <set>
#include <string>

namespace reamsim {

/// Which command wrote a results folder.
enum class ResultKind { run, comparison, verification, benchmark };

/// The first entry below `dir`, relative to it, that no command of this kind wrote: one that its manifest does not list
/// (in older or unfinished folders: with another name), a link, or an entry that cannot be read. nullopt where there is
/// none.
std::optional<std::string> foreign_entry(const std::string& dir, ResultKind kind);

/// Whether `dir` holds a file that marks a finished folder of this kind.
bool is_marked(const std::string& dir, ResultKind kind);

/// Writes DIR/manifest.json with what reamsim wrote, except the files `foreign`. `durable`: it is on the disk on
/// return. Throws RunError.
void list_results(const std::string& dir, ResultKind kind, const std::set<std::string>& foreign = {},
                  bool durable = true);

/// Marks the manifest of DIR, if it has one, as incomplete until list_results(): files will be added. Returns the files
/// that are not ours. Throws RunError.
std::set<std::string> open_results(const std::string& dir, ResultKind kind);

/// Removes from `dir` what a command of this kind wrote, then `dir` itself if it is empty. Returns whether
/// `dir` is gone.
bool remove_results(const std::string& dir, ResultKind kind);

}  // namespace reamsim
