// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/error.h"
#include "sim/scenario/key_visitor.h"

namespace reamsim {

/// A key as data: its description by describe_scenario(), its default, and the keys below it.
struct KeyNode {
  KeyInfo info;
  std::string path;          ///< "motion.plunge.feed_mm_s"; "motion.keyframes[].time_s" inside a list
  std::string default_json;  ///< "" = none
  std::vector<KeyNode> children;
  std::vector<KeyGroup> groups;

  [[nodiscard]] const KeyNode* find(std::string_view name) const;
};

/// All keys; the root is a section without a name. Built once.
const KeyNode& key_tree();

/// The unit in a key's name, "mm/s" for "feed_mm_s", or "".
std::string_view unit_of(std::string_view name);

/// A key's name without its unit, "feed" for "feed_mm_s".
std::string_view without_unit(std::string_view name);

/// The values that a key accepts, in words: "a number, 0.01 to 5 (mm)", "one of left, right".
std::string expectation(const KeyInfo& info);

/// A value as YAML on one line, its texts by `text_of`; "": not given.
std::string value_text(const KeyInfo& info, const ValuePointer& value,
                       const std::function<std::string(const std::string&)>& text_of);

/// A range in words: "0.01 to 5", or "".
std::string range_text(const Range& range);

/// "a, b or c".
std::string join_or(const std::vector<std::string_view>& words);

/// The key of a path as `--set` takes it: "motion.passes.0.tool.mesh". Throws InputError at `where` for an unknown one,
/// with the key that was probably meant, and for a section or list.
const KeyNode& find_key(const std::string& path, const SourceLocation& where);

/// What to say of an unknown key in `section`: "did you mean feed_mm_s (mm/s)?", or the keys there are.
std::string suggest_key(const KeyNode& section, const std::string& unknown);

/// The one of `words` that `unknown` probably stands for: "did you mean sobol?", else "expected one of ...".
std::string suggest_word(const std::vector<std::string_view>& words, const std::string& unknown);

}  // namespace reamsim
