// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace reamsim {

/// Bytes of the UTF-8 character at `text[at]`, 1 to 4, or 0 for an invalid one (stray, overlong, surrogate, cut off).
std::size_t utf8_length(std::string_view text, std::size_t at);

/// Whether a text is valid UTF-8 on one line: no control characters, line separators or changes of the writing
/// direction, with which a name could pass for something else on a terminal.
bool is_printable(std::string_view text);

/// `text` with every byte that is_printable() excludes as `\xNN`.
std::string printable(std::string_view text);

}  // namespace reamsim
