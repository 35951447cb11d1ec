// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "sim/base/error.h"
#include "sim/scenario/key_tree.h"

namespace reamsim {

/// The key of a path as `--set` takes it: "motion.plunge.depth_mm", "motion.passes.0.tool.mesh". Throws InputError at
/// `where` for an unknown one, with the key that was probably meant, and for a section or list.
const KeyNode& find_key(const std::string& path, const SourceLocation& where);

/// What to say of an unknown key in `section`: "did you mean feed_mm_s (mm/s)?", or the keys there are.
std::string suggest_key(const KeyNode& section, const std::string& unknown);

/// The one of `words` that `unknown` probably stands for: "did you mean sobol?", else "expected one of ...".
std::string suggest_word(const std::vector<std::string_view>& words, const std::string& unknown);

}  // namespace reamsim
