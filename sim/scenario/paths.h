#pragma once

#include <string>

#include "sim/base/error.h"
#include "sim/scenario/key_visitor.h"

namespace reamsim {

/// Expands ${VAR} from the environment ("$${" stands for "${"), and makes the path absolute: relative to `folder`.
/// An input must exist, be readable, and be a file where `kind` says so. "" stays "".
/// Throws InputError with `where` and `key`.
std::string resolve_path(const std::string& text, TextKind kind, const std::string& folder, const SourceLocation& where,
                         const std::string& key);

/// A path written so that resolve_path() gives it back: "${" becomes "$${".
std::string escape_path(const std::string& path);

}  // namespace reamsim
