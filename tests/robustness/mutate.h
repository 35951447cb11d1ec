// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <random>
#include <string>

namespace reamsim::test {

using Random = std::mt19937_64;

/// Damages a file in one to three ways: bytes, numbers, lines of a header, length, blocks.
std::string mutated(std::string bytes, Random& random);

/// The same, or in ways that suit YAML, JSON and CSV: values, brackets, indentation, lines.
std::string mutated_text(std::string text, Random& random);

}  // namespace reamsim::test
