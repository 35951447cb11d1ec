#pragma once

#include <optional>
#include <string>

namespace reamsim {

/// Which command wrote a results folder.
enum class ResultKind { run, comparison, verification, benchmark };

/// The first entry below `dir`, relative to it, that no command of this kind writes: another name, a link, a folder
/// where a file belongs. nullopt where there is none, as in an empty folder. An entry that cannot be read counts as
/// foreign.
std::optional<std::string> foreign_entry(const std::string& dir, ResultKind kind);

/// Whether `dir` holds the file by which a finished folder of this kind is recognised.
bool is_marked(const std::string& dir, ResultKind kind);

/// Removes from `dir` what a command of this kind writes, then `dir` itself. Whatever else is in it stays.
void remove_results(const std::string& dir, ResultKind kind);

}  // namespace reamsim
