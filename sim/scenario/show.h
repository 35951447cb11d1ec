// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/scenario/yaml_tree.h"

namespace reamsim {

/// A user's text for a message: in double quotes, printable(), cut after 60 bytes.
std::string shown_text(std::string_view text);

/// A file name for a message: without quotes, otherwise as shown_text(), cut after 300 bytes.
std::string shown_path(std::string_view path);

/// A user's key for a message: unchanged where it is a plain name, else as shown_text().
std::string shown_key(std::string_view key);

/// A node in words: 0.25, the text "abc", a list of 3, a section of keys, nothing.
std::string shown(const YamlNode& node);

/// A node as YAML on one line: 0.25, "a b", [0, 0, 5]. `quotes`: texts that have them keep them.
std::string flow_text(const YamlNode& node, bool quotes);

/// The shortest decimal that reads back as the same double, a number for every YAML and JSON reader (1.0e+20).
std::string number_text(double value);

/// "[1, 2, 3]".
std::string vector_text(const Vec3& v);

/// The number that the whole text is; infinite or NaN where written so or overflowing; nullopt for other text.
std::optional<double> parse_number(std::string_view text);

/// A text as a YAML scalar: plain where that is safe, else in double quotes.
std::string yaml_scalar(std::string_view text);

/// A text as a double-quoted JSON string.
std::string json_string(std::string_view text);

/// Keys with their values as text: ("motion.plunge.entry_mm", "[0, 0, 1]").
using ScenarioValues = std::vector<std::pair<std::string, std::string>>;

/// Every value of a scenario that can change a number of the results, in the order of the document.
ScenarioValues values_of_scenario(const YamlNode& document);

}  // namespace reamsim
