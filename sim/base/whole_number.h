// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace reamsim {

/// The number that a text of digits is; nothing where it is another text or the number has more than 64 bits.
std::optional<std::uint64_t> whole_number(std::string_view text);

}  // namespace reamsim
