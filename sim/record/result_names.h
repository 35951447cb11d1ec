#pragma once

#include <optional>
#include <string>

namespace reamsim {

/// Which command wrote a results folder.
enum class ResultKind { run, comparison, verification, benchmark };

/// The first entry below `dir`, relative to it, that no command of this kind writes: another name, a link, a folder in
/// place of a file, or an entry that cannot be read. nullopt where there is none.
std::optional<std::string> foreign_entry(const std::string& dir, ResultKind kind);

/// Whether `dir` holds a file that marks a finished folder of this kind.
bool is_marked(const std::string& dir, ResultKind kind);

/// Removes from `dir` what a command of this kind writes, then `dir` itself if it is empty.
void remove_results(const std::string& dir, ResultKind kind);

}  // namespace reamsim
