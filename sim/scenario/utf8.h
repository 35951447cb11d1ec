#pragma once

#include <cstddef>
#include <string_view>

namespace reamsim {

/// Bytes of the UTF-8 character at `text[at]`, 1 to 4; 0 where there is none (stray, overlong, surrogate, cut off).
std::size_t utf8_length(std::string_view text, std::size_t at);

}  // namespace reamsim
